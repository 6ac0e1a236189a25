import os
from typing import Any

import xarray as xr

from chaosdrill.analysis.measures.measured import series_measures as series_measures
from chaosdrill.analysis.measures.orders import event_orders as event_orders
from chaosdrill.analysis.measures.pairs import recurrences as recurrences
from chaosdrill.archive import cut as cut
from chaosdrill.archive import join as join
from chaosdrill.archive import open as open
from chaosdrill.archive import save as save
from chaosdrill.dataset import Outcome as Outcome
from chaosdrill.errors import ArchiveError as ArchiveError
from chaosdrill.errors import ChaosdrillError as ChaosdrillError
from chaosdrill.errors import ModelError as ModelError
from chaosdrill.errors import SceneError as SceneError
from chaosdrill.errors import SettingsError as SettingsError
from chaosdrill.errors import StartWarning as StartWarning
from chaosdrill.model import HybridSystem as HybridSystem
from chaosdrill.model import Map as Map
from chaosdrill.model import Transition as Transition
from chaosdrill.model.drives import driven as driven
from chaosdrill.model.filippov import equivalent_control as equivalent_control
from chaosdrill.model.filippov import filippov as filippov
from chaosdrill.model.halved import halved as halved
from chaosdrill.model.kinks import in_modes as in_modes
from chaosdrill.model.levels import on_level as on_level
from chaosdrill.model.noise import Choice as Choice
from chaosdrill.model.noise import Exponential as Exponential
from chaosdrill.model.noise import LogNormal as LogNormal
from chaosdrill.model.noise import Normal as Normal
from chaosdrill.model.noise import Uniform as Uniform
from chaosdrill.plots import animate as animate
from chaosdrill.plots import plot as plot
from chaosdrill.plots import plot_archive as plot_archive
from chaosdrill.progress import Progress
from chaosdrill.reports import report as report
from chaosdrill.scene import check as check
from chaosdrill.scene import list_names as list_names
from chaosdrill.scene import load_scene as load_scene
from chaosdrill.scene import new_scene as new_scene
from chaosdrill.scene import parse_scene as parse_scene
from chaosdrill.scene import save_scene as save_scene
from chaosdrill.systems import build as build
from chaosdrill.systems.drill import drill as drill
from chaosdrill.workflow import cite as cite
from chaosdrill.workflow import info as info
from chaosdrill.workflow import run as run
from chaosdrill.workflow import system as system
from chaosdrill.workflow import verify as verify

__version__: str

def attractors(
    system: HybridSystem,
    sweep: dict[str, Any],
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float,
    at: str | None = None,
    max_return: float | None = None,
    exponents: int | None = None,
    max_period: int = 64,
    max_extension: int = 8,
    initial: Any = None,
    random: dict[str, Any] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def basin_measures(
    system: HybridSystem,
    grid: dict[str, Any] | None = None,
    sweep: dict[str, Any] | None = None,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float,
    at: str | None = None,
    max_return: float | None = None,
    exponents: int | None = None,
    max_period: int = 64,
    max_extension: int = 8,
    initial: Any = None,
    box: int = 5,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def basins(
    system: HybridSystem,
    grid: dict[str, Any] | None = None,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float,
    at: str | None = None,
    max_return: float | None = None,
    exponents: int | None = None,
    max_period: int = 64,
    max_extension: int = 8,
    initial: Any = None,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def bifurcation_diagram(
    system: HybridSystem,
    sweep: dict[str, Any],
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float,
    at: str | None = None,
    max_return: float | None = None,
    exponents: int | None = None,
    max_period: int = 64,
    max_extension: int = 8,
    seeds: list[dict[str, Any]] | None = None,
    random: dict[str, Any] | None = None,
    follow: str | None = None,
    section_points: int | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def continue_orbit(
    system: HybridSystem,
    sweep: dict[str, Any],
    *,
    period: int = 1,
    at: str | None = None,
    max_return: float | None = None,
    transient: float = 200,
    start: str = "attractor",
    doublings: int = 0,
    follow: str | None = None,
    step: float | None = None,
    max_points: int = 2000,
    derivatives: bool | list[str] = False,
    functions: dict[str, Any] | None = None,
    levels: dict[str, Any] | None = None,
    optima: list[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-13,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def covariant_vectors(
    system: HybridSystem,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    interval: float | None = None,
    forward: float | None = None,
    backward: float | None = None,
    exponents: int | None = None,
    bins: int = 64,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def dimensions(
    system: HybridSystem,
    sweep: dict[str, Any] | None = None,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    max_period: int = 64,
    orders: list[int] | None = None,
    window: int = 10,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def edge_states(
    system: HybridSystem,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float,
    at: str | None = None,
    max_return: float | None = None,
    exponents: int | None = None,
    max_period: int = 64,
    max_extension: int = 8,
    initial: Any = None,
    random: dict[str, Any] | None = None,
    rounds: int = 20,
    closest: float = 1e-08,
    parted: float = 1e-05,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def equilibria(
    system: HybridSystem,
    sweep: dict[str, Any] | None = None,
    *,
    region: dict[str, Any] | None = None,
    seeds: list[dict[str, Any]] | None = None,
    starts: int = 100,
    modes: list[str] | None = None,
    step: float | None = None,
    max_points: int = 2000,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def finite_time_exponents(
    system: HybridSystem,
    sweep: dict[str, Any] | None = None,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    windows: list[float] | None = None,
    exponents: int | None = None,
    bins: int = 64,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def lyapunov_spectrum(
    system: HybridSystem,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    exponents: int | None = None,
    blocks: int = 256,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def manifolds(
    system: HybridSystem,
    orbit: Any = None,
    *,
    period: int = 1,
    at: str | None = None,
    max_return: float | None = None,
    transient: float = 200,
    start: str = "guess",
    of: str = "both",
    region: dict[str, Any] | None = None,
    length: float = 10.0,
    spacing: float = 0.01,
    accuracy: float = 1e-08,
    max_points: int = 20000,
    method: str = "taylor",
    tolerance: float = 1e-13,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def parameter_chart(
    system: HybridSystem,
    sweep: dict[str, Any],
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float,
    at: str | None = None,
    max_return: float | None = None,
    exponents: int | None = None,
    max_period: int = 64,
    max_extension: int = 8,
    seeds: list[dict[str, Any]] | None = None,
    random: dict[str, Any] | None = None,
    section_points: int = 0,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def periodic_orbit(
    system: HybridSystem,
    *,
    period: int = 1,
    at: str | None = None,
    max_return: float | None = None,
    transient: float = 200,
    start: str = "attractor",
    max_period: int | None = None,
    seeds: list[dict[str, Any]] | None = None,
    random: dict[str, Any] | None = None,
    derivatives: bool | list[str] = False,
    functions: dict[str, Any] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-13,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def poincare_section(
    system: HybridSystem,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    max_period: int = 64,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def regularity(
    system: HybridSystem,
    sweep: dict[str, Any] | None = None,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    max_period: int = 64,
    plane: list[str] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def trajectory(
    system: HybridSystem,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    samples: int | None = None,
    times: Any = None,
    initial: Any = None,
    tangents: Any = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def transient_chaos(
    system: HybridSystem,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float | None = None,
    random: dict[str, Any] | None = None,
    initial: Any = None,
    until: str | None = None,
    saddle: str | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def work_precision(
    system: HybridSystem,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    methods: list[str] | None = None,
    tolerances: list[float] | None = None,
    steps: list[int] | None = None,
    repeats: int = 5,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
def zero_one_test(
    system: HybridSystem,
    sweep: dict[str, Any] | None = None,
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    at: str | None = None,
    max_return: float | None = None,
    max_period: int = 64,
    workers: int = 1,
    scheduler: str | None = None,
    store: str | os.PathLike[str] | None = None,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    max_events: int | None = None,
    max_stalls: int = 50,
    progress: Progress | bool | None = None,
) -> xr.Dataset: ...
