"""One analysis per file, named like its function: settings, variables, citations, and how it is run."""
