"""Operations on scenes and archives: run, verify, compare, describe, cite."""

from chaosdrill.workflow.compare import Check, Difference, compare
from chaosdrill.workflow.describe import cite, info
from chaosdrill.workflow.rebuild import system
from chaosdrill.workflow.run_scene import run
from chaosdrill.workflow.verify import Verification, verify

__all__ = ["Check", "Difference", "Verification", "cite", "compare", "info", "run", "system", "verify"]
