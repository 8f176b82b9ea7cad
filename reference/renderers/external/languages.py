"""Hand a scene over to a program, in the language that it reads."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from converters.scene_folder import write_scene_folder
from minirt.scene import Scene
from reference.renderers.mitsuba.cli import export_aov
from reference.source import Unsupported

#: What a program is given: minirt's own JSON, or the scene in another program's language.
SceneAs = Literal["json", "mitsuba", "povray", "obj"]
#: What a program writes; mitsuba: the channels of its `aov` integrator, in OpenEXR.
OutAs = Literal["exr", "npz", "folder", "mitsuba"]


def hand_over(scene: Scene, scene_as: SceneAs, out_as: OutAs, workdir: Path) -> Path:
    """Write the scene below a program's working folder; return the path of its main file.

    Raises
    ------
    Unsupported
        The scene cannot be expressed in that language.
    """
    folder = workdir / "scene"
    if scene_as == "json":
        return write_scene_folder(scene, folder)
    if scene_as == "mitsuba":
        from converters.mitsuba.scene import export_mitsuba, unsupported_camera

        fault = unsupported_camera(scene.screen)
        if fault:
            raise Unsupported(fault)
        if out_as == "mitsuba":
            return export_aov(scene, folder)
        export_mitsuba(scene, folder)
        return folder / "scene.xml"
    if scene_as == "obj":
        from converters.obj import export_obj

        export_obj(scene, folder)
        return folder / "scene.obj"
    from converters.povray.scene import export_povray

    folder.mkdir()
    export_povray(scene, folder / "scene.pov")
    return folder / "scene.pov"
