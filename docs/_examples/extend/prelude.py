"""What the page takes for granted: its second example is a line of the registry, in which this name is known."""

from chaosdrill import systems

Entry = systems.Entry
