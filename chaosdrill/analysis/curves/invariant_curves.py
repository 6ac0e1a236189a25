"""Invariant manifolds of a saddle: its section points and eigenvectors, the curves, where these cross, the dataset."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.curves.growing import Bounds, Curve, Segment, Start, angles_between, grow
from chaosdrill.analysis.curves.section_map import SectionMap
from chaosdrill.analysis.orbit_start import orbit_start
from chaosdrill.analysis.recording import record_returns
from chaosdrill.analysis.sections import Section, find_section
from chaosdrill.analysis.tuning import CURVES
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.dataset.curves import CurveBreak, CurveEnd
from chaosdrill.engine import layout as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.analysis.base import Job
    from chaosdrill.orbits.results import FoundOrbit


_OPEN = (CurveBreak.NO_IMAGE, CurveBreak.NO_PREIMAGE)
"""Breaks without another side."""


@dataclass(frozen=True)
class Side:
    """The one-dimensional manifold of one kind, at one point of the orbit."""

    name: str  # {"stable", "unstable"}
    multiplier: float
    vector: np.ndarray  # (n,): direction, of length 1 in parts of the scale
    left: np.ndarray  # (n,): left eigenvector in the same, with vector @ left = 1


@dataclass(frozen=True)
class Point:
    """A point of the orbit on the section."""

    state: np.ndarray  # (n,): where motions from it begin
    shown: np.ndarray  # (n,): before its event
    map: SectionMap  # once around the orbit


@dataclass(frozen=True)
class Grown:
    """A curve with what it is."""

    name: str
    point: int  # which of the orbit's points it comes from
    multiplier: float
    curve: Curve | None  # None for one that could not be started
    side: int
    origin: np.ndarray  # (n,)
    behind: bool  # whether its first segment lies after an event, before which the section has its points


def manifolds_dataset(system: HybridSystem, given: Any, job: "Job") -> "xr.Dataset":
    """Manifolds of a saddle; see `chaosdrill.manifolds`."""
    from chaosdrill.orbits.find import find_orbit

    if given.orbit is not None:
        named = {} if "mode" in given.orbit or not system.names_mode else {"mode": system.initial["mode"]}
        system = system.with_initial(**named, **given.orbit)
    begin = orbit_start(system, given, job.numerics)
    found = find_orbit(begin.system, begin.period, begin.start, begin.transient, job.numerics, begin.marks)
    if found.outcome != Outcome.PERIODIC:
        words = begin.told(found.outcome, found.message)
        return _dataset(system, [], [], _bounds(system, given, job.numerics), found.outcome, words)
    where = find_section(system, given, job.numerics, timed=True)
    bounds = _bounds(system, given, job.numerics)
    points = _points(where, found, job.numerics, bounds.scale)
    if not points:
        words = "the orbit does not meet the section"
        return _dataset(system, [], [], bounds, Outcome.NO_RETURN, words)
    wanted = ("unstable", "stable") if given.of == "both" else (given.of,)
    values = np.zeros(len(system.state_names), dtype=complex)
    remarks: list[str] = []
    grown: list[Grown] = []
    total = 2 * given.max_points * len(wanted) * len(points)
    for place, point in enumerate(points):
        values, sides, told = _sides(point, wanted)
        remarks += [one for one in told if one not in remarks]
        for side in sides:
            grown += _grown(side, place, point, bounds, _onward(job, grown, total))
    if job.progress is not None:
        job.progress(total, total, None)
    outcome = Outcome.PERIODIC if any(one.curve is not None for one in grown) else Outcome.NO_SADDLE
    message = "; ".join(remarks)
    ds = _dataset(system, grown, points, bounds, outcome, message)
    return ds.assign(multiplier_real=("multiplier", values.real), multiplier_imag=("multiplier", values.imag))


def _onward(job: "Job", grown: list[Grown], total: int) -> Callable[[int], None] | None:
    """What is called with the points of the curves that grow, beside those that have."""
    progress = job.progress
    if progress is None:
        return None
    done = sum(one.curve.points for one in grown if one.curve is not None)
    return lambda count: progress(min(done + count, total), total, None)


def _bounds(system: HybridSystem, given: Any, numerics: Numerics) -> Bounds:
    """The region and its sides: as given, and twice the sizes of the states on either side of zero."""
    from chaosdrill.orbits.problem import Problem

    names = system.state_names
    region = np.zeros((2, len(names)))
    if len(given.region or ()) < len(names):
        size = 2 * Problem(system, (), numerics).sizes
        region[:] = np.array([-size, size])
    for name, ends in (given.region or {}).items():
        region[:, names.index(name)] = ends
    return Bounds(given.spacing, given.accuracy, given.length, given.max_points, region, region[1] - region[0])


def _points(where: Section, found: "FoundOrbit", numerics: Numerics, scale: np.ndarray) -> list[Point]:
    """The points of an orbit on the section, each with the map once around the orbit from there."""
    system = where.system

    def placed(state: np.ndarray, mode: int) -> Section:
        start = dict(zip(system.state_names, state.tolist(), strict=True))
        return replace(where, system=system.with_initial(**start, mode=system.mode_names[mode]))

    if where.transitions is None:
        states, modes = found.states, [found.mode]
        for state in states[:-1]:
            once = SectionMap(placed(state, modes[-1]), 1, numerics, modes[-1], scale)
            modes.append(once.image(state, modes[-1]).mode)
        return [
            Point(state, state, SectionMap(placed(state, mode), len(states), numerics, mode, scale))
            for state, mode in zip(states, modes, strict=True)
        ]
    count, n = max(1, len(found.section)), len(system.state_names)
    run = Run(placed(found.states[0], found.mode).system, where.unit, numerics)
    record = record_returns(run, where.transitions, count, where.longest)
    if record.outcome != Outcome.OK:
        return []
    points = []
    for row in record.events:
        kind = int(row[at.EVENT_KIND])
        before, after = row[at.EVENT_COLUMNS :].reshape(2, n)
        mode = int(run.tables.transitions[kind, at.TO_MODE])
        around = SectionMap(placed(after, mode), count, numerics, mode, scale, kind)
        points.append(Point(after.copy(), before.copy(), around))
    return points


def _sides(point: Point, wanted: Sequence[str]) -> tuple[np.ndarray, list[Side], list[str]]:
    """Multipliers at a point, the one-dimensional manifolds asked for, and why others are not grown."""
    onward, n = point.map, point.map.n
    image = onward.image(point.state, onward.mode)
    if image.outcome != Outcome.OK:
        return np.full(n, complex(np.nan, np.nan)), [], ["the orbit cannot be followed once around"]
    matrix = image.jacobian * onward.scale / onward.scale[:, np.newaxis]
    values, vectors = np.linalg.eig(matrix)
    order = np.argsort(-np.abs(values), kind="stable")
    values, vectors = values[order], vectors[:, order]
    # deviations along the flow lead to the same point of the section
    real = values[: n - 1] if onward.at_events else values
    lefts = np.linalg.pinv(vectors)
    sides, told = [], []
    for name in wanted:
        grows = np.abs(real) > 1 + CURVES.neutral if name == "unstable" else np.abs(real) < 1 - CURVES.neutral
        places = np.flatnonzero(grows)
        if len(places) != 1:
            listed = ", ".join(f"{value.real:.6g}{f'{value.imag:+.6g}i' if value.imag else ''}" for value in real)
            told.append(f"the {name} manifold has {len(places)} dimensions, not one: the multipliers are {listed}")
            continue
        k = int(places[0])
        if name == "stable" and onward.loses_rank(image):
            told.append("the stable manifold has no preimages to follow: rank is lost on the orbit")
            continue
        if name == "stable" and onward.at_events and not onward.surface:
            told.append(
                "the stable manifold is not followed over a section of events that move the state; name a surface, "
                "a comparison of states, in place of the event"
            )
            continue
        vector, left = vectors[:, k].real, lefts[k].real
        size = float(np.linalg.norm(vector)) * np.sign(vector[int(np.argmax(np.abs(vector)))])
        sides.append(Side(name, float(values[k].real), vector / size, left * size))
    return values, sides, told


def _grown(side: Side, place: int, point: Point, bounds: Bounds, report: Any) -> list[Grown]:
    """Both branches of one manifold."""
    starts = _starts(side, point, bounds)
    backward = side.name == "stable"
    curves: dict[int, Curve | None] = {1: None, -1: None}
    if starts is not None:
        segments = {sign: Segment(point.map, backward, start, bounds) for sign, start in starts.items()}
        curves |= grow(segments, side.multiplier < 0, bounds, report)
    behind = point.map.at_events and not point.map.surface
    return [
        Grown(side.name, place, side.multiplier, curve, sign, point.shown, behind) for sign, curve in curves.items()
    ]


def _starts(side: Side, point: Point, bounds: Bounds) -> dict[int, Start] | None:
    """First segments on both sides, short enough for the manifold to be straight; None where it never is.

    From a point along the eigenvector to its image. By how far that is off the eigenvector the manifold is curved, an
    error of second order: it has to fall by more than half when the segment is halved, or nothing smooth is there.
    """
    onward, scale = point.map, bounds.scale
    backward = side.name == "stable"
    growth = 1 / side.multiplier if backward else side.multiplier
    distance = bounds.spacing / max(1.0, abs(growth))
    own = onward.image(point.state, onward.mode).kinds.tolist()
    noise = CURVES.noise * onward.numerics.step_error * float(np.abs(point.state / scale).max() + distance)
    before = np.inf
    for _ in range(CURVES.halvings):
        if distance < CURVES.shortest_start:
            return None
        images = {sign: _first_image(side, point, sign * distance, growth, scale, own) for sign in (1, -1)}
        if all(image is not None for image in images.values()):
            off = max(_off(side, point, image, scale) for image in images.values() if image is not None)
            smooth = off <= CURVES.second_order * before or off <= noise
            if off <= bounds.accuracy and smooth and np.isfinite(before):
                break
            before = off
        else:
            before = np.inf
        distance /= 2
    else:
        return None
    found = {}
    for sign in (1, -1):
        begin = point.state + sign * distance * side.vector * scale
        end = images[-sign if growth < 0 else sign]
        assert end is not None
        found[sign] = Start(begin, end, abs(growth), max(off, noise), onward.mode)
    return found


def _first_image(
    side: Side, point: Point, distance: float, growth: float, scale: np.ndarray, own: list[int]
) -> np.ndarray | None:
    """The image of a point next to the orbit, with the events of the orbit; None if it has others."""
    onward = point.map
    begin = point.state + distance * side.vector * scale
    if side.name == "unstable":
        image = onward.image(begin, onward.mode)
        fine = image.outcome == Outcome.OK and image.kinds.tolist() == own and image.mode == onward.mode
        return image.state if fine else None
    guess = point.state + growth * distance * side.vector * scale
    one = onward.preimage(begin, onward.mode, guess, max(1.0, abs(growth)) * abs(distance))
    return one.state if one is not None and one.image.kinds.tolist() == own else None


def _off(side: Side, point: Point, image: np.ndarray, scale: np.ndarray) -> float:
    """How far an image is from the eigenvector, in parts of the scale."""
    away = (image - point.state) / scale
    onward = point.map
    if onward.at_events and not onward.surface:
        rates = onward.flow(point.state) / scale
        away = away - rates * float(rates @ away) / float(rates @ rates)
    return float(np.linalg.norm(away - side.vector * float(side.left @ away)))


@dataclass(frozen=True)
class _Line:
    """A curve as points of the dataset."""

    states: np.ndarray  # (m, n)
    arclength: np.ndarray
    error: np.ndarray
    generation: np.ndarray
    part: np.ndarray  # int (m,): number of the part, which a cut ends
    breaks: list[tuple[int, float, Any, float]]  # place of the point before it, arclength, break, size


def _line(one: Grown, bounds: Bounds) -> _Line:
    """All pieces of a curve in a row, without what is outside the region; the point of the orbit first."""
    n, count = len(one.origin), 1
    states, error, generation = [one.origin[np.newaxis]], [np.zeros(1)], [np.zeros(1, dtype=np.int64)]
    links, breaks = [np.ones(1, dtype=bool)], []
    joined = True
    for k, piece in enumerate([] if one.curve is None else one.curve.pieces):
        if k == 0 and one.behind:
            joined = False
            continue
        # an image begins where the one before has ended
        seam = count > 1 and joined and bool(piece.kept[0])
        kept = np.flatnonzero(piece.kept)[int(seam) :]
        link = np.concatenate([[count == 1 and joined], piece.kept[:-1] & ~piece.cut])[kept]
        first = count - int(seam)
        places = first + np.cumsum(piece.kept) - 1
        breaks += [(int(places[i]), found) for i, found in piece.breaks.items()]
        states.append(piece.states[kept])
        error.append(piece.error[kept])
        generation.append(np.full(len(kept), k))
        links.append(link)
        count += len(kept)
        joined = bool(piece.kept[-1])
    rows, together = np.concatenate(states).reshape(-1, n), np.concatenate(links)
    steps = np.linalg.norm(np.diff(rows / bounds.scale, axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(np.where(together[1:], steps, 0.0))])
    listed = []
    for place, found in breaks:
        i = max(place, 0)
        size = float(steps[i]) if i < len(steps) and found.kind not in _OPEN else np.nan
        listed.append((i, float(lengths[i]), found, size))
    return _Line(rows, lengths, np.concatenate(error), np.concatenate(generation), np.cumsum(~together), listed)


def _dataset(
    system: HybridSystem, grown: list[Grown], points: list[Point], bounds: Bounds, outcome: Outcome, message: str
) -> "xr.Dataset":
    n = len(system.state_names)
    lines = [_line(one, bounds) for one in grown]
    counts = [len(line.states) for line in lines]
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(int)

    def joined(name: str, shape: tuple[int, ...] = (), dtype: Any = float) -> np.ndarray:
        rows = [np.asarray(getattr(line, name)) for line in lines]
        return np.concatenate(rows).astype(dtype) if rows else np.zeros((0, *shape), dtype=dtype)

    breaks = [
        (k, starts[k] + i, length, one, size) for k, line in enumerate(lines) for i, length, one, size in line.breaks
    ]
    ends = [CurveEnd.NOT_STARTED if one.curve is None else one.curve.end for one in grown]
    crossings = _crossings(grown, lines, bounds) if n == 2 else _NO_CROSSINGS
    variables: dict[str, Any] = {
        "curve_state": (("point", "state"), joined("states", (n,))),
        "curve": ("point", np.repeat(np.arange(1, len(lines) + 1), counts).astype(np.int32)),
        "part": ("point", joined("part", (), np.int32)),
        "arclength": ("point", joined("arclength")),
        "generation": ("point", joined("generation", (), np.int32)),
        "curve_error": ("point", joined("error")),
        "curve_stable": ("curve_number", np.array([one.name == "stable" for one in grown], dtype=np.int8)),
        "curve_point": ("curve_number", np.array([one.point + 1 for one in grown], dtype=np.int32)),
        "curve_side": ("curve_number", np.array([one.side for one in grown], dtype=np.int8)),
        "curve_multiplier": ("curve_number", np.array([one.multiplier for one in grown], dtype=float)),
        "curve_length": ("curve_number", np.array([line.arclength[-1] for line in lines], dtype=float)),
        "curve_end": ("curve_number", np.array(ends, dtype=np.int8)),
        "break_curve": ("break", np.array([k + 1 for k, *_ in breaks], dtype=np.int32)),
        "break_point": ("break", np.array([place for _, place, *_ in breaks], dtype=np.int32)),
        "break_arclength": ("break", np.array([length for _, _, length, _, _ in breaks], dtype=float)),
        "break_kind": ("break", np.array([one.kind for *_, one, _ in breaks], dtype=np.int8)),
        "break_jump": ("break", np.array([one.jump for *_, one, _ in breaks], dtype=np.int8)),
        "break_size": ("break", np.array([size for *_, size in breaks], dtype=float)),
        "break_generation": ("break", np.array([one.generation for *_, one, _ in breaks], dtype=np.int32)),
        "break_state": (("break", "state"), np.array([one.state for *_, one, _ in breaks]).reshape(-1, n)),
        "crossing_state": (("crossing", "state"), crossings.states.reshape(-1, n)),
        "crossing_error": ("crossing", crossings.errors),
        "crossing_angle": ("crossing", crossings.angles),
        "crossing_unstable": ("crossing", crossings.unstable),
        "crossing_stable": ("crossing", crossings.stable),
        "orbit_section": (("iterate", "state"), np.array([one.shown for one in points]).reshape(-1, n)),
        "region": (("end", "state"), bounds.region),
        "multiplier_real": ("multiplier", np.full(n, np.nan)),
        "multiplier_imag": ("multiplier", np.full(n, np.nan)),
        "outcome": ((), np.int8(outcome)),
    }
    if system.forced:
        variables["forcing_period"] = ((), system.forcing_period())
    coords = {
        "state": list(system.state_names),
        "curve_number": np.arange(1, len(lines) + 1, dtype=np.int32),
        "multiplier": np.arange(1, n + 1, dtype=np.int32),
        "iterate": np.arange(len(points), dtype=np.int32),
    }
    return dataset(variables | coords, coords).assign_attrs(message=message)


@dataclass(frozen=True)
class _Crossings:
    states: np.ndarray  # (K, 2)
    errors: np.ndarray  # (K,): in parts of the scale
    angles: np.ndarray  # (K,): between the curves, in the same
    unstable: np.ndarray  # int (K,): numbers of the curves
    stable: np.ndarray


_NO_CROSSINGS = _Crossings(
    np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32)
)


def _chords(
    grown: list[Grown], lines: list[_Line], name: str, bounds: Bounds
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Ends of all chords of one kind of curves in parts of the scale, how far these are off, their curves' numbers."""
    begins, ends, off, numbers = [np.zeros((0, 2))], [np.zeros((0, 2))], [np.zeros(0)], [np.zeros(0, dtype=np.int32)]
    for k, (one, line) in enumerate(zip(grown, lines, strict=True)):
        if one.name != name or len(line.states) < 3:
            continue
        rows = line.states / bounds.scale
        steps = np.diff(rows, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        angles = np.concatenate([[0.0], angles_between(steps, lengths), [0.0]])
        bow = lengths * np.maximum(angles[:-1], angles[1:]) / 8
        # the two branches of an orbit's point and all others meet there
        whole = (np.diff(line.part) == 0) & (np.arange(len(steps)) > 0)
        begins.append(rows[:-1][whole])
        ends.append(rows[1:][whole])
        off.append((bow + np.maximum(line.error[:-1], line.error[1:]))[whole])
        numbers.append(np.full(int(whole.sum()), k + 1, dtype=np.int32))
    return np.concatenate(begins), np.concatenate(ends), np.concatenate(off), np.concatenate(numbers)


def _crossings(grown: list[Grown], lines: list[_Line], bounds: Bounds) -> _Crossings:
    """Where unstable and stable curves in a plane cross: homoclinic and heteroclinic points."""
    from scipy.spatial import cKDTree

    a0, a1, a_off, a_numbers = _chords(grown, lines, "unstable", bounds)
    b0, b1, b_off, b_numbers = _chords(grown, lines, "stable", bounds)
    if not len(a0) or not len(b0):
        return _NO_CROSSINGS
    longest = max(float(np.linalg.norm(a1 - a0, axis=1).max()), float(np.linalg.norm(b1 - b0, axis=1).max()))
    tree = cKDTree((b0 + b1) / 2)
    near = tree.query_ball_point((a0 + a1) / 2, longest)
    counts = np.array([len(one) for one in near])
    i = np.repeat(np.arange(len(a0)), counts)
    j = np.concatenate([np.array(one, dtype=np.int64) for one in near]) if counts.sum() else np.zeros(0, dtype=np.int64)
    u, v, w = a1[i] - a0[i], b1[j] - b0[j], b0[j] - a0[i]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (w[:, 0] * v[:, 1] - w[:, 1] * v[:, 0]) / area
        t = (w[:, 0] * u[:, 1] - w[:, 1] * u[:, 0]) / area
    cross = (area != 0) & (s >= 0) & (s < 1) & (t >= 0) & (t < 1)
    i, j, s, area = (part[cross][: CURVES.most_crossings] for part in (i, j, s, area))
    sine = np.abs(area) / (np.linalg.norm(a1[i] - a0[i], axis=1) * np.linalg.norm(b1[j] - b0[j], axis=1))
    states = (a0[i] + s[:, np.newaxis] * (a1[i] - a0[i])) * bounds.scale
    errors = (a_off[i] + b_off[j]) / np.maximum(sine, np.finfo(float).eps)
    return _Crossings(states, errors, np.arcsin(np.minimum(sine, 1.0)), a_numbers[i], b_numbers[j])
