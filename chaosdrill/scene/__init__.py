"""A scene: a TOML file that names a system and what is to be computed of it."""

from chaosdrill.scene.load import load_scene, parse_scene
from chaosdrill.scene.scene import Scene

__all__ = ["Scene", "load_scene", "parse_scene"]
