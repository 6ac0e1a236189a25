"""What is done with scenes and archives: run, verified, run again, compared, described, cited."""

from chaosdrill.workflow.compare import Check, Difference, compare
from chaosdrill.workflow.describe import cite, info
from chaosdrill.workflow.run_scene import run
from chaosdrill.workflow.verify import Verification, verify

__all__ = ["Check", "Difference", "Verification", "cite", "compare", "info", "run", "verify"]
