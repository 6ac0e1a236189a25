"""Several threads that ask for the kernels of one system at once get them, whole."""

import pickle
import sys
import threading

import chaosdrill as cd


def test_kernels_that_several_threads_ask_for_at_once():
    system = cd.build("impact-oscillator")
    ahead = system.kernels
    names = [f"chaosdrill_{path.stem}" for path in (ahead.path, ahead.lanes_path)]
    for name in names:
        sys.modules.pop(name, None)
    # copies that were sent one by one share nothing but the generated files
    copies = [pickle.loads(pickle.dumps(system)) for _ in range(4)]
    barrier, found = threading.Barrier(len(copies)), []

    def ask(copy):
        barrier.wait()
        found.append((copy.kernels.functions, copy.kernels.lanes))

    threads = [threading.Thread(target=ask, args=(copy,)) for copy in copies]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == len(copies)
    assert all(functions is not None for pair in found for functions in pair)
    assert len({id(pair[1][0]) for pair in found}) == 1
