"""A scene: a TOML file that names a system and the analyses to run."""

from chaosdrill.scene.describe import check
from chaosdrill.scene.load import load_scene, parse_scene
from chaosdrill.scene.names import list_names, new_scene
from chaosdrill.scene.scene import Scene
from chaosdrill.scene.write import save_scene

__all__ = ["Scene", "check", "list_names", "load_scene", "new_scene", "parse_scene", "save_scene"]
