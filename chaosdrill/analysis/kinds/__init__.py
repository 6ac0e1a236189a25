"""One analysis a file, named as its function: settings, variables, citations, and how it is run."""
