"""Every public name of the package is on the page of the Python interface, and that page has no other."""

import chaosdrill
from chaosdrill import errors


def check_names(app, env) -> None:
    """Stop the build where the page and ``chaosdrill.__all__`` differ."""
    from sphinx.errors import ExtensionError

    objects = env.domaindata["py"]["objects"]
    documented = {name.removeprefix("chaosdrill.") for name, entry in objects.items() if entry.objtype != "module"}
    public = {f"errors.{name}" if name in errors.__all__ else name for name in chaosdrill.__all__}
    missing = public - documented - {"__version__"}
    other = {name for name in documented if "." not in name} - public
    if missing or other:
        raise ExtensionError(f"docs/api.md: not there: {sorted(missing)}; there, but not public: {sorted(other)}")


def setup(app) -> dict[str, bool]:
    """Check once all pages are read."""
    app.connect("env-check-consistency", check_names)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
