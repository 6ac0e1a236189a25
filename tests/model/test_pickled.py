"""A system that was sent to another process is the same one: same code, same numbers; kernels stay behind."""

import pickle
import subprocess
import sys

import pytest

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.kernels import write

SPECTRUM = """
import pickle, sys
import chaosdrill as cd
system = pickle.load(sys.stdin.buffer)
ds = cd.lyapunov_spectrum(system, periods=50, transient=5)
sys.stdout.buffer.write(ds["lyapunov_exponent"].values.tobytes())
"""


@pytest.mark.parametrize("name", sorted(systems.REGISTRY))
def test_its_content_is_the_same(name):
    system = systems.build(name)
    other = pickle.loads(pickle.dumps(system))
    assert other._content() == system._content()
    assert other.parameters == system.parameters
    assert other.initial == system.initial
    assert other.bounds == system.bounds


@pytest.mark.parametrize("name", ["percussive-drill", "relay-sliding", "compass-gait"])
def test_generated_code_is_the_same(name):
    system = systems.build(name)
    assert write(pickle.loads(pickle.dumps(system)).placed).single == write(system.placed).single


def test_kernels_are_left_out_and_shared_again_by_copies_that_are_sent_together():
    system = cd.build("impact-oscillator")
    assert kernels_of(system) is not None
    one, other = pickle.loads(pickle.dumps((system, system.with_parameters(omega=2.6))))
    assert not one.shared
    assert kernels_of(one) is kernels_of(other)
    assert kernels_of(one).written.single == kernels_of(system).written.single


def test_another_process_gets_the_same_bits():
    system = cd.build("impact-oscillator")
    here = cd.lyapunov_spectrum(system, periods=50, transient=5)["lyapunov_exponent"].values
    command = [sys.executable, "-c", SPECTRUM]
    done = subprocess.run(command, input=pickle.dumps(system), capture_output=True, timeout=120, check=True)
    assert done.stdout == here.tobytes()


def test_systems_that_differ_in_numbers_alone_share_what_was_derived():
    one, other = cd.drill(eta=0.63), cd.drill(eta=0.45)
    assert kernels_of(one) is kernels_of(other)
    assert one.parameters["eta"] == 0.63
    assert other.parameters["eta"] == 0.45
    assert kernels_of(cd.drill(friction="none")) is not kernels_of(one)
