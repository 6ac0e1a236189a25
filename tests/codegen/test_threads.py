"""Several threads that ask for the kernels of one system at once get them, whole."""

import pickle
import threading

import numpy as np

import chaosdrill as cd
from chaosdrill.codegen import kernels_of


def test_kernels_that_several_threads_ask_for_at_once():
    system = cd.build("impact-oscillator")
    # copies that were sent one by one share nothing but the files of compiled code
    copies = [pickle.loads(pickle.dumps(system)) for _ in range(4)]
    barrier, found = threading.Barrier(len(copies)), []

    def ask(copy):
        barrier.wait()
        kernels, rates = kernels_of(copy), np.empty(2)
        kernels.functions[3](0, 0.3, kernels.constants(copy.parameters), np.array([0.1, 0.7]), rates)
        found.append((tuple(rates), len(kernels.lanes)))

    threads = [threading.Thread(target=ask, args=(copy,)) for copy in copies]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == len(copies)
    assert len(set(found)) == 1
