"""What makes a function an analysis: its settings are its signature, its table in a scene, and its provenance."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from inspect import Parameter, Signature, cleandoc
from textwrap import fill
from typing import TYPE_CHECKING, Any, ClassVar, cast
from warnings import warn

from chaosdrill.analysis.arguments import (
    LONGEST_PERIOD,
    At,
    Axes,
    Exponents,
    Method,
    example_of_section,
    misfits_of_duration,
    misfits_of_section,
)
from chaosdrill.analysis.spans import Span
from chaosdrill.analysis.starts import told_of_starts
from chaosdrill.annotations import Dataset as Dataset
from chaosdrill.dataset.references import SPECTRA
from chaosdrill.dataset.schema import Table, rate_clash
from chaosdrill.declared import ANALYSES, METHODS, unfit
from chaosdrill.engine.methods import DEFAULT
from chaosdrill.errors import ModelError, SettingsError, StartWarning
from chaosdrill.names import key_text
from chaosdrill.progress import Progress, teller, watched
from chaosdrill.settings import Amount, Faults, Number, Settings, Whole, setting, told, whole
from chaosdrill.typed import FOLDER, LISTENER, given_to, refuse

if TYPE_CHECKING:
    from chaosdrill.engine.numerics import Numerics
    from chaosdrill.model import HybridSystem as HybridSystem
else:
    # in annotations of analyses alone, which must not import it
    HybridSystem = Any


@dataclass(frozen=True, kw_only=True)
class AnalysisSettings(Settings):
    """What the settings of every analysis say of it."""

    parallel: ClassVar[bool] = False
    """Whether it has many points, which several workers can share."""
    own_numerics: ClassVar[bool] = False
    """Whether it names methods and tolerances itself, and takes none from the table numerics."""
    needs_section: ClassVar[bool] = False
    """Whether there is nothing to show without a section, so that a system without forcing must have one named."""
    reserves: ClassVar[bool] = True
    """Whether the names of its variables are kept from all sweeps, grids and quadratures, if it holds names of users;
    else only from its own sweeps."""
    tolerance: ClassVar[float] = 1e-12
    meanings: ClassVar[Mapping[str, str]] = {
        "system": "System with its parameters and initial state.",
        "workers": "Threads; the kernels release the interpreter's lock.",
        "scheduler": "Address of a Dask scheduler, whose workers are used instead.",
        "store": "Folder for finished chunks, from which the same call resumes if it was interrupted; those of another "
        "call are refused.",
        "progress": "Called with (done, total, outcomes counted so far, or None for a single run). True shows a bar in "
        "a terminal or notebook, and lines elsewhere; False shows nothing; by default a bar appears in a terminal or "
        "notebook after one second.",
    }
    without_noise: ClassVar[str] = "it looks for repeating motion, and with parameters drawn at events nothing repeats"
    """Why the analysis refuses a system with noise; empty if it does not."""

    @classmethod
    def noise_faults(cls, system: "HybridSystem") -> Faults:
        """Noise where it has no meaning."""
        if system.noise and cls.without_noise:
            names = ", ".join(map(repr, system.noise))
            yield (), f"{system.name} draws {names} anew, which this analysis does not take: {cls.without_noise}"

    @classmethod
    def shared(cls, table: Mapping[str, Any]) -> bool:
        """Whether there are points for several workers, by the arguments."""
        return cls.parallel


_SECTION = (
    'The section: the name or kind of a transition; ``"strobe"``, forcing phase zero, by default; or a comparison such '
    'as ``"x > 0"``, which marks the surface on which it becomes true. Required without forcing where points of a '
    "section are recorded. At an event the state before it is recorded."
)

_RETURN = (
    "Longest time between two points of an event or a surface: a run that meets none within a whole multiple of this "
    "time, counted from its start, ends with the outcome ``no_return``, or ``equilibrium`` if it is at rest. Default "
    "1000 forcing periods, or 1000 times the time in which the motion from the initial state crosses its own extent."
)


@dataclass(frozen=True, kw_only=True)
class _Lengths(AnalysisSettings):
    """How long runs are: in forcing periods or points of a section, or in time for a system without a forcing."""

    ends: ClassVar[tuple[str, ...]] = ()
    """Other settings that tell how long a run is."""

    periods: int | None = setting(
        Whole(1), None, doc="Points of the section to record: forcing periods, or events or crossings named by ``at``."
    )
    duration: float | None = setting(
        Amount(above=0),
        None,
        doc="Time to record instead; for systems without a forcing period.",
    )
    transient: float = setting(
        Amount(least=0),
        0,
        doc="Points of the section, or time, to run before the record starts, in the unit of the length of the record.",
    )
    at: str | None = setting(At(), None, doc=_SECTION)
    max_return: float | None = setting(Number(above=0), None, doc=_RETURN)

    def counts(self, system: "HybridSystem") -> str:
        """What lengths count: ``"strobe"``, ``"section"`` (its points) or ``"time"``."""
        return "time" if self.duration is not None else "strobe" if self.at in (None, "strobe") else "section"

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """Both lengths, or none."""
        if "periods" in table and "duration" in table:
            yield ("duration",), told("periods are given, too; leave one of them out", table["duration"])
        elif not {"periods", "duration", *cls.ends} & table.keys():
            yield (), "give either periods (of the forcing, or points of the section) or duration (units of time)"

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: "HybridSystem") -> Faults:
        """A length that the system does not count, and a section that it lacks."""
        yield from misfits_of_section(table, system)
        yield from misfits_of_duration(table, system)
        at = table.get("at")
        if system.forced:
            return
        if cls.needs_section and at is None:
            example = example_of_section(system)
            yield (), f"{system.name} has no forcing period, and so no strobe; name a section, as in {example}"
        elif "periods" in table and at in (None, "strobe"):
            words = f"{system.name} has no forcing period; give duration, in units of time, or the section whose "
            yield ("periods",), told(f"{words}points are counted, as in {example_of_section(system)}", table["periods"])


@dataclass(frozen=True, kw_only=True)
class Record(_Lengths):
    """A run of one length."""

    def span(self, system: "HybridSystem", numerics: Any, *, units: int = 1) -> Span:
        """How long to run; ``units`` parts make a duration."""
        match self.counts(system):
            case "strobe":
                return Span(cast(float, system.forcing_period()), int(cast(int, self.periods)), self.transient, True)
            case "time":
                return Span(float(cast(float, self.duration)) / units, units, self.transient, False)
        from chaosdrill.analysis.sections import find_section, measured_span

        return measured_span(find_section(system, self, numerics), self, numerics, units)


@dataclass(frozen=True, kw_only=True)
class SectionRecord(Record):
    """A run of which the points of a section are recorded."""

    needs_section: ClassVar[bool] = True

    max_period: int = setting(Whole(1, 1_000_000), 64, doc="Longest period to detect, in iterates of the section.")


@dataclass(frozen=True, kw_only=True)
class OverParameter(AnalysisSettings):
    """An analysis at the system's own parameters, or at every value of one of them."""

    parallel: ClassVar[bool] = True
    reserves: ClassVar[bool] = False

    sweep: dict[str, Any] | None = setting(
        Axes("parameter", 1, 1, "one parameter can be swept"),
        None,
        doc='``{"eta": np.linspace(0.4, 0.9, 501)}``: a record at every value, each from the system\'s own initial '
        "state.",
        positional=True,
    )

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: "HybridSystem") -> Faults:
        """A parameter that is called as one of the variables."""
        yield from super().misfits(table, system)
        (variables,) = (entry.variables for entry in ANALYSES.values() if entry.settings is cls)
        taken = {name for one in variables for name in (one.name, *one.dims)}
        for name in table.get("sweep") or ():
            if name in taken:
                yield ("sweep", name), "is a variable of the result, and cannot be swept; rename the parameter"


@dataclass(frozen=True, kw_only=True)
class Swept(OverParameter, Record):
    """A run, or one at every value of a parameter."""

    meanings: ClassVar[Mapping[str, str]] = {
        "workers": "Threads among which the values of a sweep are shared; the kernels release the interpreter's lock.",
        "store": "Folder for finished values of a sweep, from which the same call resumes if it was interrupted; those "
        "of another call are refused.",
    }

    @classmethod
    def shared(cls, table: Mapping[str, Any]) -> bool:
        return table.get("sweep") is not None


@dataclass(frozen=True, kw_only=True)
class SweptRecord(Swept, SectionRecord):
    """A run of which the points of a section are recorded, or one at every value of a parameter."""


@dataclass(frozen=True, kw_only=True)
class Points(_Lengths):
    """What sweeps and basins share: every point is a run of its own."""

    parallel: ClassVar[bool] = True
    meanings: ClassVar[Mapping[str, str]] = {
        "duration": "Time to average over instead, for systems without a forcing period; the transient, a time too, is "
        "rounded up to a whole part of it, of 544. Without a section no period is detected.",
        "max_return": f"{_RETURN} The other points go on.",
    }

    transient: float = setting(Amount(least=0), doc="Points of the section, or time, to run before the record starts.")
    periods: int | None = setting(
        Whole(2),
        None,
        doc="Points of the section to record and to average the exponents over: forcing periods, or events named by "
        "``at``.",
    )
    exponents: int | None = setting(
        Exponents(),
        None,
        doc="Number of exponents; default all; 0 for none, so that recurrence alone classifies, without extension.",
    )
    max_period: int = setting(
        Whole(1, 10_000),
        64,
        doc="Longest period to detect, in iterates of the section; the record must contain two.",
    )
    max_extension: int = setting(
        Whole(0), 8, doc="How many times ``periods`` an undecided run may be extended by; 0 for no extension."
    )


@dataclass(frozen=True, kw_only=True)
class Orbit(AnalysisSettings):
    """An orbit by its period."""

    tolerance: ClassVar[float] = 1e-13

    period: int = setting(
        Whole(1, LONGEST_PERIOD),
        1,
        doc="Period in forcing periods; without forcing in points of the section ``at``, and 1, one revolution, if "
        "none is named. An orbit whose least period divides this number is reported with its least period.",
    )
    at: str | None = setting(
        At(),
        None,
        doc="Of a system without forcing: the section whose points ``period`` and ``transient`` count, as in "
        "`poincare_section`. Newton's method then starts at the closest return after this number of points.",
    )
    max_return: float | None = setting(Number(above=0), None, doc=_RETURN)
    transient: float = setting(
        Amount(least=0),
        200,
        doc='Forcing periods, points of the section (without either: time) to run first, with ``start="attractor"``.',
    )

    def counts(self, system: "HybridSystem") -> str:
        """What the period and the transient count."""
        return "section" if self.at not in (None, "strobe") else "strobe" if system.forced else "time"

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: "HybridSystem") -> Faults:
        """Lengths in periods without forcing, or in something else with it; a section that does not exist."""
        yield from misfits_of_section(table, system)
        sectioned = table.get("at") not in (None, "strobe")
        if sectioned and system.forced:
            counted = "is a map, whose orbits are counted in iterates"
            if not system.discrete:
                counted = "has a forcing period, in which orbits are counted"
            words = f"{system.name} {counted}; leave it out"
            yield ("at",), told(words, table["at"])
        if not system.forced and not sectioned and table.get("period", 1) != 1:
            words = f"{system.name} has no forcing period to count in; leave it out: an orbit is one round then, "
            words += "however many turns it takes; or name the section whose points it counts, as in "
            words += example_of_section(system)
            yield ("period",), told(words, table["period"])


@dataclass(frozen=True, kw_only=True)
class NumericsSettings(Settings):
    """Method, its tolerance, the steps a period of a method with a fixed step, and the limits of its events."""

    method: str = setting(Method(), DEFAULT, doc="Numerical method.")
    tolerance: float = setting(
        Number(1e-16, 1e-2),
        1e-12,
        doc='Local error per step of every state, relative to its recent magnitude ("taylor", "dop853", "radau"); '
        'bisection of event times ("rk4").',
    )
    steps: int | None = setting(Whole(4, 10_000_000), None, doc='Steps per period, for "rk4" only; default 200.')
    max_events: int | None = setting(
        Whole(1, 1_000_000_000),
        None,
        doc="Largest number of events per period, beyond which a run ends with the outcome ``event_limit``; for "
        "systems without a period the limit applies to the whole transient and to the whole run after it. Default "
        "10,000, or ten million without a period.",
    )
    max_stalls: int = setting(
        Whole(1, 1_000_000_000),
        50,
        doc="Largest number of successive events without advance of time, beyond which a run ends with the outcome "
        "``stalled``.",
    )

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """Steps for a method that chooses its own."""
        method = table.get("method", cls.default("method"))
        if "steps" in table and isinstance(method, str) and method in METHODS and not METHODS[method].fixed_step:
            others = " or ".join(name for name, one in METHODS.items() if one.fixed_step)
            yield ("steps",), told(f"{method} chooses its own steps; leave it out, or choose {others}", table["steps"])


@dataclass(frozen=True)
class Job:
    """How an analysis is carried out, apart from its settings.

    ``numerics`` is None for an analysis that names its own.
    """

    numerics: Any
    workers: int = 1
    scheduler: str | None = None
    store: str | os.PathLike[str] | None = None
    progress: Progress | None = None

    def report(self, total: int) -> Callable[[int], None] | None:
        """Function to call with the periods done and their total; None without a listener."""
        progress = self.progress
        return None if progress is None else lambda done: progress(done, total, None)


_TYPES = {
    "system": "HybridSystem",
    "workers": "int, default 1",
    "scheduler": "str, optional",
    "store": "path-like, optional",
    "progress": "callable or bool, optional",
}
"""Types of the arguments that are no settings, in words."""

_RAISES = """\
Raises
------
SettingsError
    An argument that cannot be used."""

_OF_STORES = """\
ArchiveError
    If the ``store`` cannot be written, or another call uses it.
ChaosdrillError
    If the scheduler cannot be reached or is lost, or if its workers have other versions."""

POINTS = (*SPECTRA, "smith1987", "das2017", "gottwald2009")
ORBITS = ("mueller1995", "dankowicz2013", "dercole2005", "dibernardo2008")
"""What analyses of the same family cite, by keys of the list of references."""

_SYSTEM = Parameter("system", Parameter.POSITIONAL_OR_KEYWORD, annotation="HybridSystem")
_EXECUTION = {
    name: Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
    for name, default, annotation in (
        ("workers", 1, int),
        ("scheduler", None, str | None),
        ("store", None, str | os.PathLike[str] | None),
    )
}


@dataclass(frozen=True)
class Analysis:
    """One kind of analysis."""

    kind: str  # its name in scenes and archives
    function: str  # its name in Python
    summary: str  # a line about it
    settings: type[AnalysisSettings]  # its arguments
    variables: Table  # what it puts out
    cites: tuple[str, ...]  # keys of its references
    run: "Callable[[HybridSystem, Any, Job], Dataset]"
    """Given the system, its settings and a `Job`, computes the bare dataset."""

    def signature(self) -> Signature:
        """Of the function that users call."""
        of = self.settings
        numerics = {} if of.own_numerics else {one.name: one for one in NumericsSettings.signature()}
        if numerics:
            numerics["tolerance"] = numerics["tolerance"].replace(default=of.tolerance)
        return Signature(
            [
                _SYSTEM,
                *of.signature(),
                *(_EXECUTION.values() if of.parallel else ()),
                *numerics.values(),
                Parameter("progress", Parameter.KEYWORD_ONLY, default=None, annotation="Progress | bool | None"),
            ],
            return_annotation="xr.Dataset",
        )

    def described(self) -> dict[str, str]:
        """Type, default and meaning of each setting, in a line."""
        arguments = self._arguments()
        return {name: ": ".join(arguments[name]) for name in self.told()}

    def _arguments(self) -> dict[str, tuple[str, str]]:
        """Type and meaning of each argument of the function."""
        of, meant = self.settings, self.settings.meant()
        numerics = {} if of.own_numerics else NumericsSettings.described()
        if numerics:
            numerics["tolerance"] = (f"float, default {of.tolerance:g}", numerics["tolerance"][1])
        others = {name: (kind, meant[name]) for name, kind in _TYPES.items()}
        given = {name: (kind, meant.get(name, text)) for name, (kind, text) in numerics.items()}
        return others | given | of.described()

    def documented(self) -> str | None:
        """The docstring of the function that users call, with its arguments; None where Python leaves docstrings out.

        That of ``run`` says everything but what the arguments mean, and which errors they, a store and a scheduler
        bring; errors of its own it says itself.
        """
        if self.run.__doc__ is None:
            return None
        head, rest = cleandoc(self.run.__doc__).split("Returns\n-------\n")
        arguments = self._arguments()
        lines = ["Parameters", "----------"]
        for name in self.signature().parameters:
            kind, text = arguments[name]
            indent = " " * 4
            told = fill(text, 116, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False)
            lines += [f"{name} : {kind}", told]
        told, *literature = rest.split("\nReferences\n----------\n")
        if "\nRaises\n" not in told:
            told = f"{told.rstrip()}\n\n{_RAISES}\n"
        if self.settings.parallel:
            told = f"{told.rstrip()}\n{_OF_STORES}\n"
        sections = [f"\nReferences\n----------\n{one}" for one in literature]
        return "\n".join([head.rstrip(), "", *lines, "", "Returns", "-------", "".join([told, *sections]).rstrip()])

    def told(self) -> tuple[str, ...]:
        """What is kept as provenance: all arguments that determine the numbers, but for the system."""
        return (*self.settings.values(), *(() if self.settings.own_numerics else NumericsSettings.values()))

    def __call__(self, given: dict[str, Any]) -> "Dataset":
        """Run with all arguments of the function, and label what comes of it.

        Raises `SettingsError` for an argument that cannot be used, `ModelError` for a quadrature that no archive could
        hold.
        """
        from chaosdrill.codegen.record import remember
        from chaosdrill.dataset import label
        from chaosdrill.engine.ahead import ONE_RUN, compile_ahead
        from chaosdrill.model.regions import check_parameters
        from chaosdrill.model.system import SYSTEM

        if "system" not in given:
            raise TypeError(f"{self.function}() missing a required argument: 'system'")
        system = given["system"]
        refuse(SettingsError, "system", system, SYSTEM)
        for name in system.quadratures:
            if reason := unfit(name):
                told = f"has a name that {reason}; rename it, as in 'the_integral'"
                raise ModelError(f"{system.name}: quadrature {name!r:.60} {told}")
        axes = (given.get(name) for name in ("sweep", "grid"))
        taken = {key_text(name) for one in (system.quadratures, *axes) if isinstance(one, Mapping) for name in one}
        if clash := rate_clash(system.quadratures, taken):
            raise ModelError(f"{system.name}: {clash}")
        for name, kind in (("progress", LISTENER), ("store", FOLDER)):
            if given.get(name) is not None:
                refuse(SettingsError, name, given[name], kind)
        system.forcing_period()
        for _, told in self.settings.noise_faults(system):
            raise SettingsError(f"{self.function}: {told}")
        try:
            settings = self.settings.read(given, system)
        except TypeError as fault:
            raise TypeError(f"{self.function}() {fault}; see help(chaosdrill.{self.function})") from None
        if not self.settings.parallel or not getattr(settings, "sweep", None):
            check_parameters(system)
        numerics = {} if self.settings.own_numerics else vars(NumericsSettings.read(given, system))
        execution = {name: given[name] for name in _EXECUTION if name in given}
        if execution:
            execution["workers"] = whole("workers", execution["workers"], 1)
        job = Job(_numerics(numerics) if numerics else None, **execution, progress=teller(given["progress"]))
        if not self.settings.parallel and not system.discrete:
            compile_ahead(ONE_RUN)
        found = self.run(system, settings, job)
        if "outcome" in found and (told := told_of_starts(system, found["outcome"].values)):
            # of whoever calls the function
            warn(f"{self.function}: {told}", StartWarning, stacklevel=4)
            found.attrs.setdefault("message", told)
        kept = {name: getattr(settings, name) for name in self.settings.values()} | numerics
        labelled = label(found, self.kind, system=system, settings=kept)
        labelled.attrs |= found.attrs
        remember(system)
        return labelled


def _numerics(given: Mapping[str, Any]) -> "Numerics":
    from chaosdrill.engine.numerics import Numerics

    return Numerics(**given)


def analysis(
    kind: str, settings: type[AnalysisSettings], summary: str, variables: Table, *, cites: tuple[str, ...] = ()
) -> Callable[[Callable[..., Any]], Any]:
    """Make an analysis of a function that computes a dataset from a system, its settings and a `Job`.

    The parameters are fields of `Analysis`.
    """

    def wrap(run: Callable[..., Any]) -> Any:
        entry = Analysis(kind, run.__name__, summary, settings, variables, cites, run)
        ANALYSES.enter(kind, entry)
        signature = entry.signature()

        def called(*arguments: Any, **keywords: Any) -> Any:
            given_system = arguments[0] if arguments else keywords.get("system")
            given = given_to(entry.function, signature, arguments, keywords, given_system)
            given.apply_defaults()
            return entry(given.arguments)

        called.__name__, called.__qualname__, called.__module__ = run.__name__, run.__qualname__, run.__module__
        called.__doc__ = entry.documented()
        called.__signature__ = signature  # type: ignore[attr-defined]
        called.analysis = entry  # type: ignore[attr-defined]
        return watched(called)

    return wrap
