"""Covariant vectors, against eigenvectors, tangent maps from both sides, and closed forms across events."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import sympy
from scipy.linalg import expm, subspace_angles
from support.discrete import clocked

import chaosdrill as cd
from chaosdrill.analysis.measures import covariant


def unit(vectors):
    """Columns of length 1."""
    return vectors / np.linalg.norm(vectors, axis=-2, keepdims=True)


def apart(found, wanted):
    """Largest distance between directions in columns, whatever their signs."""
    return np.minimum(*(np.linalg.norm(unit(found) - sign * unit(wanted), axis=-2) for sign in (1, -1))).max()


def carried(system, start, length, columns):
    """What the tangent map takes columns to, by the run that records trajectories."""
    moved = cd.trajectory(system.with_initial(**start), **length, tangents=columns.T.tolist())
    return moved["final_tangent"].transpose("state", "tangent").values


def linear(kick, rates, name="linear"):
    """Rest of a linear system that is kicked linearly once a period; the tangent map is known in closed form."""
    x, y, z, clock = sympy.symbols("x y z clock", real=True)
    states = sympy.Matrix([x, y, z])
    flow, image = sympy.Matrix(rates) * states, sympy.Matrix(kick) * states
    return cd.HybridSystem(
        name=name, states=(x, y, z, clock), parameters={},
        modes={"on": {x: flow[0], y: flow[1], z: flow[2], clock: 1}},
        transitions=[cd.Transition("kick", "on", "on", clock - 1, 1,
                                   {x: image[0], y: image[1], z: image[2], clock: 0})],
        period=sympy.Integer(1), initial={x: 0.0, y: 0.0, z: 0.0, clock: 0.5},
    )  # fmt: skip


RATES = np.array([[0.3, 0.2, 0.0], [-0.3, -0.2, 0.4], [0.1, 0.0, -0.7]])
KICK = np.array([[2.0, 1.0, 0.0], [1.0, 1.0, 0.5], [0.0, 0.2, 0.4]])


# Fixed points and cycles: eigenvectors.


def test_vectors_of_a_rest_that_is_kicked_are_eigenvectors():
    half = expm(RATES / 2)
    values, exact = np.linalg.eig(half @ KICK @ half)
    order = np.argsort(-abs(values))
    assert np.isreal(values).all()
    found = cd.covariant_vectors(linear(KICK, RATES), periods=5)
    live = [i for i in range(4) if abs(found["vector"].values[0, 3, i]) < 0.5]
    np.testing.assert_allclose(found["lyapunov_exponent"].values[live], np.log(abs(values[order])), rtol=0, atol=1e-11)
    assert apart(found["vector"].values[:, :3, live], exact[:, order]) < 1e-11
    assert apart(found["vector"].values[:, :, [i for i in range(4) if i not in live]], np.eye(4)[:, 3:]) < 1e-11
    # a vector keeps the sign that the map gives it
    ahead = half @ KICK @ half @ found["vector"].values[2, :3, live].T
    np.testing.assert_allclose(unit(ahead), found["vector"].values[3, :3, live].T, rtol=0, atol=1e-11)


def test_time_reversed_the_vectors_are_those_in_reverse():
    there = cd.covariant_vectors(linear(KICK, RATES), periods=3)
    back = cd.covariant_vectors(linear(np.linalg.inv(KICK), -RATES, "reversed"), periods=3)
    assert apart(there["vector"].values, back["vector"].values[:, :, ::-1]) < 1e-10
    np.testing.assert_allclose(back["lyapunov_exponent"], -there["lyapunov_exponent"][::-1], rtol=0, atol=1e-10)


@pytest.mark.parametrize(("omega", "lead"), [(2.65, 40), (2.7, 14)])
def test_on_a_cycle_they_are_eigenvectors_of_the_monodromy_matrix(omega, lead):
    """The second one is unstable: a run stays on it for as long as round-off lets it."""
    parameters = {"omega": omega, "e": 0.5, "wall": 0.0, "zeta": 0.0}
    system = cd.build("impact-oscillator").with_parameters(**parameters)
    orbits = cd.periodic_orbit(system, start="search", max_period=1, tolerance=1e-14)
    orbit = orbits.isel(orbit=int(np.flatnonzero(orbits["impacts_per_period"].values == 1)[0]))
    multipliers = orbit["multiplier_real"].values
    assert (abs(multipliers[0]) < 1) == (omega == 2.65)
    start = dict(zip("xv", orbit["orbit_state"].values.tolist(), strict=True))
    values, exact = np.linalg.eig(carried(system, start, {"periods": 1, "tolerance": 1e-14}, np.eye(2)))
    found = cd.covariant_vectors(system.with_initial(**start), periods=4, forward=lead, backward=lead, tolerance=1e-14)
    growth = np.exp(found["lyapunov_exponent"].values * float(orbit["forcing_period"]))
    np.testing.assert_allclose(growth, abs(multipliers), rtol=1e-10)
    assert apart(found["vector"].values, exact[:, np.argsort(-abs(values))]) < 1e-9
    # both multipliers are negative: a period turns every vector round
    assert ((found["vector"].values[1:] * found["vector"].values[:-1]).sum(axis=1) < 0).all()


def test_of_a_spiral_no_single_vector_is_known():
    system = cd.build("impact-oscillator").with_parameters(omega=2.4, e=0.8, wall=0.0, zeta=0.0)
    found = cd.covariant_vectors(system, periods=20, transient=300)
    assert (found["vector_error"] > 0.1).all()


MATRIX = {f"a{i}{j}": 0.0 for i in range(3) for j in range(3)}
LINEAR = cd.Map("x y z", MATRIX, ["a00*x + a01*y + a02*z", "a10*x + a11*y + a12*z", "a20*x + a21*y + a22*z"])
BASIS = np.array([[0.35, 0.82, 0.33], [-1.3, 0.91, 0.45], [-0.54, 0.58, 0.36]])


def of_matrix(blocks):
    """Covariant vectors of a fixed point, whose matrix is given in another basis."""
    matrix = BASIS @ blocks @ np.linalg.inv(BASIS)
    system = LINEAR.with_parameters(**dict(zip(MATRIX, matrix.ravel().tolist(), strict=True)))
    return cd.covariant_vectors(system, periods=200, forward=100, backward=100)


@pytest.mark.parametrize("real", [0.5, 2.0])
def test_of_a_spiral_beside_a_real_multiplier_the_subspace_is_known(real):
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    blocks = np.zeros((3, 3))
    blocks[:2, :2], blocks[2, 2] = 1.2 * turn, real
    found = of_matrix(blocks)
    alone, pair = (2, [0, 1]) if real < 1 else (0, [1, 2])
    vectors, told = found["vector"].values, found["vector_error"].values
    assert apart(vectors[:, :, [alone]], BASIS[:, 2:]) < 1e-12
    assert (told[:, alone] < 1e-11).all()
    # as small as 0.33 where the first has once grown more
    assert (told[:, pair] == 1.0).all()
    both = np.linalg.qr(BASIS[:, :2])[0]
    assert np.abs(vectors[:, :, pair] - both @ (both.T @ vectors[:, :, pair])).max() < 1e-12


@pytest.mark.parametrize("powers", [(40, 0, -40), (-40, 0, 40), (0, 40, 0)])
def test_vectors_and_their_errors_do_not_depend_on_units(powers):
    """A Henon map of three states: in the units of the second case a direction was lost, in all errors were 1e-12."""
    henon = cd.Map(
        "x y z", {"X": 1.0, "Y": 1.0, "Z": 1.0}, ["X*(1.76 - (y/Y)**2 - 0.1*z/Z)", "Y*x/X", "Z*y/Y"],
        bounds=dict.fromkeys("xyz"),
    )  # fmt: skip
    found = []
    for units in (np.ones(3), 2.0 ** np.array(powers)):
        start = dict(zip("xyz", (np.array([0.1, 0.2, 0.1]) * units).tolist(), strict=True))
        system = henon.with_parameters(**dict(zip("XYZ", units.tolist(), strict=True))).with_initial(**start)
        found.append(cd.covariant_vectors(system, transient=50, periods=100, forward=200, backward=200))
    here, there = found
    np.testing.assert_array_equal(there["states"], here["states"] * units)
    told = here["vector_error"].values
    np.testing.assert_allclose(there["vector_error"], told, rtol=1e-9)
    away = unit(there["vector"].values / units[:, np.newaxis])
    away = np.minimum(*(np.linalg.norm(away - sign * here["vector"].values, axis=1) for sign in (1, -1)))
    assert (away <= 10 * told + 1e-11).all()


# Maps.


def test_of_a_map_of_the_torus_they_are_eigenvectors_of_its_matrix():
    x, y = sympy.symbols("x y", real=True)
    cat = clocked("cat", (x, y), {}, {x: sympy.Mod(3 * x + 2 * y, 1), y: sympy.Mod(x + y, 1)}, {x: 0.1, y: 0.37})
    found = cd.covariant_vectors(cat, periods=50, bins=8)
    root = np.sqrt(3.0)
    np.testing.assert_allclose(found["lyapunov_exponent"], [np.log(2 + root), 0, np.log(2 - root)], rtol=0, atol=1e-11)
    exact = np.array([[1 + root, 0, 1 - root], [1, 0, 1], [0, 1, 0]])
    assert apart(found["vector"].values, exact) < 1e-11
    along = unit(exact)[:, 0] @ unit(exact)[:, 2]
    # the clock's direction is across both
    np.testing.assert_allclose(found["angle"], np.full((50, 2), np.arccos(abs(along))), rtol=0, atol=1e-11)
    histogram = found["angle_histogram"] * (np.pi / 16)
    np.testing.assert_allclose(histogram.max("bin"), 1.0)
    assert (histogram.argmax("bin") == int(np.arccos(abs(along)) / (np.pi / 16))).all()


def test_of_henons_map_they_come_from_the_past_and_from_the_future():
    """The first is what the past makes of any tangent; the second what the inverse map makes of any in the future."""
    x, y = sympy.symbols("x y", real=True)
    henon = clocked("henon", (x, y), {}, {x: 1 - 1.4 * x**2 + y, y: 0.3 * x}, {x: 0.1, y: 0.1})
    found = cd.covariant_vectors(henon, transient=50, forward=60, periods=300, backward=60)
    states, vectors = found["states"].values[:, :2], found["vector"].values[:, :2]
    maps = [np.array([[-2.8 * at[0], 1.0], [0.3, 0.0]]) for at in states]
    for k in (80, 150, 220):
        fast, slow = np.array([0.3, 0.8]), np.array([0.6, -0.4])
        for back in range(60):
            fast = unit((maps[k - 60 + back] @ fast)[:, np.newaxis])[:, 0]
            slow = unit(np.linalg.solve(maps[k + 59 - back], slow)[:, np.newaxis])[:, 0]
        assert apart(vectors[k][:, [0, 2]], np.column_stack([fast, slow])) < 1e-9
    # the attractor's own exponents (Henon 1976: 0.42 and -1.62)
    np.testing.assert_allclose(found["lyapunov_exponent"], [0.42, 0.0, -1.62], rtol=0, atol=0.06)
    np.testing.assert_allclose(found["lyapunov_exponent"].sum(), np.log(0.3), rtol=0, atol=0.02)


# Flows.


def test_of_the_lorenz_system_the_second_is_the_flow():
    lorenz = cd.build("lorenz")
    found = cd.covariant_vectors(lorenz, duration=40.0, transient=10.0, forward=30, backward=30, interval=0.1)
    x, y, z = found["states"].values.T
    flow = np.column_stack([10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z])
    vectors = found["vector"].values
    assert apart(vectors[:, :, 1:2], flow[:, :, np.newaxis]) < 1e-10
    # volume shrinks at the rate of the divergence at every moment, whatever the vectors
    volume = np.log(abs(np.linalg.det(vectors)))
    kept = found["local_growth"].values[:-1].sum(axis=1) * 0.1 + np.diff(volume)
    np.testing.assert_allclose(kept, -0.1 * (10 + 1 + 8 / 3), rtol=0, atol=1e-11)
    assert (found["vector_error"] < 1e-9).all()
    edge = np.arccos(abs((vectors[:, :, 0] * vectors[:, :, 1]).sum(axis=1)))
    least = found["angle"].sel(split=1).values
    assert (least <= edge + 1e-12).all()
    assert (found["smallest_angle"] == found["angle"].min("time")).all()


def test_leads_that_are_too_short_are_told():
    lorenz = cd.build("lorenz")
    exact = cd.covariant_vectors(lorenz, duration=3.0, transient=1.0, forward=8, backward=8, interval=0.1)
    short = cd.covariant_vectors(lorenz, duration=3.0, transient=7.0, forward=2, backward=2, interval=0.1)
    np.testing.assert_allclose(exact["states"], short["states"], rtol=0, atol=1e-5)
    sign = np.sign((exact["vector"] * short["vector"]).sum("state").values)[:, np.newaxis]
    away = np.linalg.norm(exact["vector"].values - short["vector"].values * sign, axis=1)
    told = short["vector_error"].values
    assert (away <= 10 * told + 1e-6).all()
    assert (told[:, 0] < 1e-3).any()
    assert (away[:, :2].max(axis=0) > 1e-3).all()


# Events.


@pytest.fixture(scope="module")
def chaotic():
    """The impact oscillator, twenty times a period."""
    return cd.covariant_vectors(cd.build("impact-oscillator"), transient=50, periods=60, interval=1 / 20)


def test_saltation_takes_the_vectors_before_an_impact_to_those_after_it(chaotic):
    """Free flight and the saltation matrix of a wall in closed form."""
    zeta, omega, e = 0.05, 2.5, 0.8
    field = np.array([[0.0, 1.0], [-1.0, -2 * zeta]])
    step = float(chaotic["forcing_period"]) / 20
    hits = 0
    shifted = cd.HybridSystem(
        states="x v", time="t", parameters={"start": 0.0},
        modes={"free": {"x": "v", "v": "-x - 0.1*v + cos(2.5*(t + start))"}},
        transitions=[cd.Transition("impact", "free", "free", "x - 0.3", 1, {"v": "-0.8*v"})],
        initial={"x": 0.0, "v": 0.0},
    )  # fmt: skip
    for k in np.flatnonzero(chaotic["states"].values[:-1, 0] > 0.1)[:60]:
        (x, v), time = chaotic["states"].values[k].tolist(), float(chaotic["time"][k])
        motion = cd.trajectory(shifted.with_parameters(start=time).with_initial(x=x, v=v), duration=step, samples=2)
        if motion.sizes["event"] != 1:
            continue
        hits += 1
        at = float(motion["event_time"][0])
        before, after = (motion[f"event_state_{name}"].values[0] for name in ("before", "after"))
        force = np.cos(omega * (time + at))
        rates = [np.array([v, -x - 2 * zeta * v + force]) for x, v in (before, after)]
        reset = np.diag([1.0, -e])
        saltation = reset + np.outer(rates[1] - reset @ rates[0], [1.0, 0.0]) / before[1]
        carried_over = expm(field * (step - at)) @ saltation @ expm(field * at) @ chaotic["vector"].values[k]
        growth = np.exp(chaotic["local_growth"].values[k] * step)
        np.testing.assert_allclose(
            carried_over, chaotic["vector"].values[k + 1] * growth, rtol=0, atol=1e-8 * growth.max()
        )
    assert hits > 5


def test_volume_is_lost_to_damping_and_impacts_alone(chaotic):
    volume = np.log(abs(np.linalg.det(chaotic["vector"].values)))
    step = float(chaotic["forcing_period"]) / 20
    kept = chaotic["local_growth"].values[:-1].sum(axis=1) * step + np.diff(volume) + 0.1 * step
    hits = kept / (2 * np.log(0.8))
    np.testing.assert_allclose(hits, np.rint(hits), rtol=0, atol=1e-9)
    assert np.rint(hits).sum() == 41


def test_the_mean_of_local_growth_is_the_exponent():
    found = cd.covariant_vectors(cd.build("impact-oscillator"), transient=50, periods=3000)
    spectrum = cd.lyapunov_spectrum(cd.build("impact-oscillator"), transient=50, periods=3000)
    apart = abs(found["lyapunov_exponent"].values - spectrum["lyapunov_exponent"].values)
    assert (apart <= 3 * np.hypot(found["lyapunov_error"].values, spectrum["lyapunov_error"].values)).all()
    mean = found["local_growth"].mean("time")
    np.testing.assert_allclose(mean, found["lyapunov_exponent"], rtol=0, atol=1e-12)


def test_scaled_and_reordered_states_have_the_same_directions():
    oscillator = cd.build("impact-oscillator")
    scaled = cd.HybridSystem(
        name="scaled", states="w q", time="t", parameters={"zeta": 0.05, "omega": 2.5, "e": 0.8},
        modes={"free": {"q": "w/1000", "w": "1000*(-q - 2*zeta*w/1000 + cos(omega*t))"}},
        transitions=[cd.Transition("impact", "free", "free", "1e6*(q - 0.3)", 1, {"w": "-e*w"})],
        period="2*pi/omega", initial={"q": 0.0, "w": 300.0},
    )  # fmt: skip
    lengths = {"periods": 10, "forward": 25, "backward": 25}
    here, there = (cd.covariant_vectors(one, **lengths)["vector"].values for one in (oscillator, scaled))
    assert apart(here, np.array([[0, 1], [1e-3, 0]]) @ there) < 1e-6


# Lost rank.


def test_what_an_event_removes_is_told_from_then_on():
    """A kick at time 20.25 puts y to zero and sends (2, -1) to zero; before it that direction is known exactly."""
    system = cd.HybridSystem(
        name="plastic", states="x y clock", parameters={"a": 0.1, "b": 0.4},
        modes={"on": {"x": "-a*x", "y": "-b*y", "clock": "1"}},
        transitions=[cd.Transition("kick", "on", "on", "clock - 20.25", 1, {"x": "x + 2*y", "y": "0"})],
        period="1", initial={"x": 0.6, "y": -0.2, "clock": 0.0},
    )  # fmt: skip
    found = cd.covariant_vectors(system, periods=20, forward=10, backward=40)
    time, lost = found["time"].values, found["lost"].values
    np.testing.assert_array_equal(lost[:, 2] == 1, time > 20.25)
    assert (lost[:, :2] == 0).all()
    gone = found["vector"].values[:, :, 2]
    assert (gone[time > 20.25] == 0).all()
    left = 20.25 - time[time < 20.25]
    removed = np.stack([2 * np.exp(0.1 * left), -np.exp(0.4 * left), 0 * left], axis=1)
    assert apart(gone[time < 20.25, :, np.newaxis], removed[:, :, np.newaxis]) < 1e-10
    growth = found["local_growth"].values
    assert np.isneginf(growth[time > 20, 2]).all()
    assert np.isfinite(growth[time < 19.5]).all()
    assert np.isneginf(found["lyapunov_exponent"].values[2])
    # what is left keeps to the line y = 0
    assert abs(found["vector"].values[time > 20.25, 1]).max() < 1e-14
    assert np.isfinite(found["vector"]).all()
    assert np.isfinite(found["angle"].sel(split=1)).all()
    np.testing.assert_array_equal(found["angle"].sel(split=2).isnull(), time > 20.25)


def test_a_drill_that_sticks_loses_one_direction_and_keeps_the_others():
    drill = cd.drill(friction="stribeck", contact="hunt-crossley", eta=0.448)
    found = cd.covariant_vectors(drill, transient=100, periods=200)
    assert int(found["outcome"]) == cd.Outcome.OK
    assert (found["lost"] == [0, 0, 1]).all()
    assert np.isfinite(found["vector"]).all()
    assert np.isneginf(found["local_growth"].values).all(axis=0).tolist() == [False, False, True]
    assert np.isfinite(found["local_growth"].values[:, :2]).all()
    for k in (0, 90, 198):
        start = dict(zip(drill.state_names, found["states"].values[k].tolist(), strict=True))
        start["mode"] = drill.mode_names[int(found["mode"][k])]
        ahead = carried(drill, start, {"periods": 1}, found["vector"].values[k, :, :2])
        growth = np.exp(found["local_growth"].values[k, :2] * float(found["forcing_period"]))
        np.testing.assert_allclose(ahead, found["vector"].values[k + 1, :, :2] * growth, rtol=0, atol=1e-8)


# How it is computed.


def test_chunks_do_not_show(monkeypatch):
    lengths = {"periods": 100, "transient": 20, "forward": 30, "backward": 30}
    oscillator = cd.build("impact-oscillator")
    whole = cd.covariant_vectors(oscillator, **lengths)
    monkeypatch.setattr(covariant, "COVARIANT", replace(covariant.COVARIANT, kept=300))
    shown = []
    parts = cd.covariant_vectors(oscillator, **lengths, progress=lambda done, total, eta: shown.append((done, total)))
    for name in ("vector", "local_growth", "angle", "states"):
        np.testing.assert_array_equal(whole[name], parts[name])
    np.testing.assert_allclose(whole["vector_error"], parts["vector_error"], rtol=1e-9)
    assert shown[-1][0] == shown[-1][1] > 200


def test_memory_is_that_of_the_results_and_of_what_is_kept():
    """Of 20,000 vectors 1.9 MB, and 17 numbers each of the forward pass; 3.8 times the results before."""
    oscillator = cd.build("impact-oscillator")
    cd.covariant_vectors(oscillator, periods=10)
    tracemalloc.start()
    found = cd.covariant_vectors(oscillator, periods=20_000, transient=10)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * found.nbytes


def test_memory_does_not_grow_with_the_length(monkeypatch):
    """With a vector each period, four times the periods took four times the memory; the first lies where it did."""
    monkeypatch.setattr(covariant, "COVARIANT", replace(covariant.COVARIANT, most=500))
    oscillator, peaks = cd.build("impact-oscillator"), []
    for periods, between, first in ((2000, 4, 500), (8003, 17, 1003)):
        tracemalloc.start()
        found = cd.covariant_vectors(oscillator, periods=periods, transient=10)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        time = found["time"].values / float(found["forcing_period"])
        np.testing.assert_allclose(np.diff(time), between, rtol=1e-9)
        assert found["interval"] / found["forcing_period"] == pytest.approx(between)
        assert len(time) == periods // between
        assert time[0] == pytest.approx(10 + first)
    assert peaks[1] < 1.3 * peaks[0]


def test_a_run_that_leaves_has_no_modes():
    """All of its samples were said to be in the first mode."""
    leaving = cd.Map("x", {}, {"x": "1 - 5*x**2"}, initial={"x": 0.9}, bounds={"x": (-9, 9)})
    found = cd.covariant_vectors(leaving, periods=20)
    assert found["outcome"] == cd.Outcome.ESCAPED
    assert set(found["mode"].values.tolist()) == {-1}
    assert np.isnan(found["states"]).all()


def test_blocks_of_any_length_give_the_same_vectors():
    lengths = {"transient": 10, "forward": 20, "periods": 16, "backward": 20}
    often, seldom = (
        cd.covariant_vectors(cd.build("impact-oscillator"), **lengths, interval=interval) for interval in (1 / 20, 4)
    )
    same = often.isel(time=slice(None, None, 80))
    np.testing.assert_allclose(same["time"], seldom["time"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(same["vector"], seldom["vector"], rtol=0, atol=1e-6)
    growth = often["local_growth"].values.reshape(4, 80, 2).mean(axis=1)
    np.testing.assert_allclose(growth, seldom["local_growth"], rtol=0, atol=1e-6)


def test_angles_between_subspaces_are_principal_angles():
    rng = np.random.default_rng(8)
    frame = np.tril(rng.normal(size=(3, 5, 5)))
    lost = np.zeros((3, 5), dtype=bool)
    lost[1, 3:] = True
    found = covariant.between(frame, lost)
    for k, live in ((0, 5), (1, 3), (2, 5)):
        exact = [subspace_angles(frame[k, :s].T, frame[k, s:live].T).min() for s in range(1, live)]
        np.testing.assert_allclose(found[k, : live - 1], exact, rtol=0, atol=1e-7)
    assert np.isnan(found[1, 2:]).all()


def test_intervals_that_do_not_fit_are_refused():
    oscillator = cd.build("impact-oscillator")
    with pytest.raises(cd.SettingsError, match="expected whole forcing periods, or one over a whole number"):
        cd.covariant_vectors(oscillator, periods=10, interval=0.3)
    with pytest.raises(cd.SettingsError, match="does not divide the record of 10 forcing periods"):
        cd.covariant_vectors(oscillator, periods=10, interval=4)
