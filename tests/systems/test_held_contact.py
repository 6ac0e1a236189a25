"""Bit and rock that stay together at the stop: when that begins, how they move, when it ends, and what it costs."""

import mpmath
import numpy as np
import pytest

import chaosdrill as cd

WALL = {"drive": "none", "rock": "fixed", "friction": "none", "xi": 0.0, "b": 0.5, "r": 0.3}


def events(run):
    return run.cd.words("event_kind").values.tolist(), run["event_time"].values


def first_hit():
    """Time and speed at which a bit that starts at rest, y = b (1 - cos t), reaches the stop."""
    time = np.arccos(1 - WALL["r"] / WALL["b"])
    return time, WALL["b"] * np.sin(time)


def flight(speed):
    """Time until a bit that leaves the stop, pressed on by b - r, is back."""
    return 2 * np.arctan(speed / (WALL["b"] - WALL["r"]))


def test_newtonian_rebounds_end_in_time():
    time, speed = first_hit()
    for j in range(1, 200):
        time += flight(speed * 0.5**j)
    run = cd.trajectory(cd.drill(contact="newton", e=0.5, **WALL), duration=20.0, samples=10)
    names, times = events(run)
    assert set(names[:-1]) == {"hit"}
    assert names[-1] == "hold-stick"
    assert times[-1] == pytest.approx(time, abs=1e-9)
    np.testing.assert_array_equal(run["states"].values[-1], [0.3, 0.0])


def peak(v, lam, k):
    """Largest k d (1 + lam d') of a contact entered at v, over a fine grid of its way in."""
    d = np.linspace(0, v, 20001)[1:]
    motion = lambda u: u / lam - np.log1p(lam * u) / lam**2  # noqa: E731
    return np.max(k * np.sqrt(np.maximum(2 * (motion(v) - motion(d)) / k, 0)) * (1 + lam * d))


def test_a_hunt_crossley_hit_is_held_once_its_force_is_no_more_than_the_load():
    k, lam = 100.0, 1.0
    time, speed = first_hit()
    count = 0
    while peak(speed, lam, k) > WALL["b"] - WALL["r"]:
        base = 1 + lam * mpmath.mpf(speed)
        speed = float((1 + mpmath.lambertw(-base * mpmath.exp(-base)).real) / lam)
        time += flight(speed)
        count += 1
    run = cd.trajectory(cd.drill(contact="hunt-crossley", k=k, lam=lam, **WALL), duration=100.0, samples=10)
    names, times = events(run)
    assert count > 10
    assert names == ["hit"] * count + ["hold-stick"]
    assert times[-1] == pytest.approx(time, abs=1e-9)
    np.testing.assert_array_equal(run["states"].values[-1], [0.3, 0.0])


DRIVEN = {"b": 0.5, "a": 0.4, "eta": 0.9, "phi": 0.0}


@pytest.mark.parametrize("friction", ["none", "coulomb"])
def test_a_bit_on_a_rock_at_rest_leaves_when_the_load_falls_below_the_spring(friction):
    rock = "fixed" if friction == "none" else "moving"
    held = cd.drill(
        rock=rock, friction=friction, contact="newton", r=0.3, **{**DRIVEN, "a": 0.3},
        initial={"mode": "stick-held", "y": 0.3},
    )  # fmt: skip
    run = cd.trajectory(held, periods=1, samples=10)
    names, times = events(run)
    assert names[0] == "part-stick"
    assert times[0] == pytest.approx(np.arccos((0.3 - 0.5) / 0.3) / 0.9, rel=1e-12)
    np.testing.assert_array_equal(run["event_state_after"].values[0][:2], [0.3, 0.0])


def test_two_masses_that_slide_as_one_obey_the_load_and_friction_alone():
    speed, eps, mu = 3.0, 2.0, 0.6
    held = cd.drill(
        friction="coulomb", contact="newton", r=0.5, eps=eps, mu=mu, xi=0.3, **DRIVEN,
        initial={"mode": "slip-held", "y": 0.5, "u": speed, "w": speed},
    )  # fmt: skip
    run = cd.trajectory(held, periods=1, samples=400)
    names, times = events(run)
    assert names[0] == "part-slip"
    # contact force: b + a cos(eta t) - r - eps (r - mu) over 1 + eps
    assert times[0] == pytest.approx(np.arccos((0.5 + eps * (0.5 - mu) - 0.5) / 0.4) / 0.9, rel=1e-12)
    t = run["time"].values
    before = t < times[0]
    exact = speed + eps / (1 + eps) * ((0.5 - mu) * t + 0.4 / 0.9 * np.sin(0.9 * t))
    np.testing.assert_allclose(run["states"].values[before, 1], exact[before], rtol=0, atol=1e-13)
    np.testing.assert_array_equal(run["states"].values[before, 1], run["states"].values[before, 2])
    np.testing.assert_array_equal(run["states"].values[before, 0], 0.5)


def test_a_held_pair_slips_when_the_load_exceeds_friction_and_sticks_again():
    held = cd.drill(
        friction="coulomb",
        contact="newton",
        mu=0.95,
        r=0.3,
        b=0.9,
        a=0.3,
        eta=0.9,
        phi=-np.pi / 2,
        initial={"mode": "stick-held", "y": 0.3},
    )
    run = cd.trajectory(held, periods=1, samples=10)
    names, times = events(run)
    assert names[:2] == ["release-held", "stick-held"]
    assert times[0] == pytest.approx(np.arcsin(0.1 / 0.3) / 0.9, rel=1e-12)
    assert float(run["penetration"][-1]) > 0


@pytest.mark.parametrize("contact", ["newton", "hunt-crossley", "hunt-crossley-timed"])
def test_rebounds_on_a_rock_that_gives_way_end_too(contact):
    # weakly driven: everything comes to rest, bit on rock; each hit lets the rock slip a little
    soft = {} if contact == "newton" else {"k": 1e4}
    run = cd.trajectory(cd.drill(contact=contact, b=0.5, a=0.1, r=0.3, eta=0.9, xi=0.1, **soft), periods=12, samples=2)
    names, _ = events(run)
    assert cd.Outcome(int(run["outcome"])) is cd.Outcome.OK
    assert {"strong-hit", "stick"} <= set(names)
    # Newton's last rebounds are too low for their tolerance, which decides whether the rock slips once more
    assert names[-1] in (("hold-stick", "stick-held") if contact == "newton" else ("hold-stick",))
    np.testing.assert_array_equal(run["states"].values[-1, :3], [0.3, 0.0, 0.0])


def test_a_contact_held_at_rest_once_a_period_leaves_no_exponent_finite():
    bit = cd.drill(rock="fixed", friction="none", contact="newton", e=0.3, r=0.3, **DRIVEN)
    spectrum = cd.lyapunov_spectrum(bit, periods=100, transient=20)
    counts = dict(zip(spectrum["transition"].values, spectrum["event_count"].values, strict=True))
    assert counts["hold-stick"] == counts["part-stick"] == 100
    assert np.all(spectrum["lyapunov_exponent"].values == -np.inf)


def test_two_masses_that_slide_together_have_one_freedom():
    # slip-held once a period: the bit's own freedom is lost there, and the stick takes the rest
    spectrum = cd.lyapunov_spectrum(
        cd.drill(contact="newton", e=0.2, friction="coulomb", b=0.5, a=0.4, r=0.3, eta=0.9, xi=0.1),
        periods=60,
        transient=20,
    )
    counts = dict(zip(spectrum["transition"].values, spectrum["event_count"].values, strict=True))
    assert counts["hold-slip"] > 50
    assert not np.isnan(spectrum["lyapunov_exponent"].values).any()
    assert np.all(spectrum["lyapunov_exponent"].values[1:] == -np.inf)
