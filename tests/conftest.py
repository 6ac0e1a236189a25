"""Settings that every test shares."""

import os

os.environ.setdefault("MPLBACKEND", "Agg")

from hypothesis import settings

# the first example of a property may wait for a compiler
settings.register_profile("chaosdrill", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("chaosdrill")
