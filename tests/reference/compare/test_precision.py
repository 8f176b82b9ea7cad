"""The bounds that follow from a number format hold for what is computed in it, and are tight."""

from __future__ import annotations

import numpy as np
import pytest

import minirt
from minirt.errors import InputError
from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from reference.compare.comparison import Comparison, compare
from reference.compare.precision import Claim, Precision, declared
from reference.compare.stability import measure
from tests.helpers.fake_references import small_scene
from tests.helpers.tiers import tiered

SCENES = ("ball-on-quad", "glass-ball", "closed-mesh", "curved-mirrors")
TYPES: dict[Precision, type] = {"float64": np.float64, "float32": np.float32, "half": np.float16}


def small(name: str) -> minirt.Scene:
    scene = minirt.load_scene(f"atlas:{name}")
    document = scene.to_dict()
    document["screen"] |= {"nx": 64, "ny": 48}
    return minirt.load_scene(document, scene.folder)


def rounded(frame: Frame, precision: Precision) -> Frame:
    """Every number of a frame through a format."""
    kind = TYPES[precision]
    arrays = {
        name: array if QUANTITIES[name].discrete else array.astype(kind).astype(np.float64)
        for name, array in frame.items()
    }
    return Frame(arrays)


def judged(scene: minirt.Scene, claim: Claim, precision: Precision) -> Comparison:
    ours, stability = measure(scene, declared(scene, claim))
    return compare(scene, ours, stability, rounded(ours, precision), {})


@pytest.mark.parametrize("name", tiered(SCENES, lambda name: name == [*SCENES][-1]))
@pytest.mark.parametrize("precision", ["float32", "half"])
def test_what_is_rounded_to_a_format_passes_as_that_and_fails_as_a_finer_one(
    name: str, precision: Precision
) -> None:
    scene = small(name)
    coarse = judged(scene, Claim(precision, handed=precision), precision)
    wrong = {check.quantity: check.wrong for check in coarse.checks if check.wrong}
    assert wrong == {}
    finer: Precision = "float64" if precision == "float32" else "float32"
    fine = judged(scene, Claim(finer, handed=finer), precision)
    assert {"t", "depth", "distance"} <= {c.quantity for c in fine.checks if c.wrong}


def test_float64_through_float32_files_is_as_sharp_at_edges_as_float64() -> None:
    scene = small_scene()
    through = declared(scene, Claim("float64", handed="float32"))
    assert through.delta == declared(scene, Claim("float64")).delta
    assert through.grain == 2.0**-24
    assert dict(through.steps)["normal"] == pytest.approx(3**0.5 * 2.0**-24)
    assert declared(scene, Claim("float64")).steps == ()


def test_secondary_rays_of_float32_may_start_beyond_its_errors() -> None:
    scene = small_scene()
    assert declared(scene, Claim("float64")).start is None
    single = declared(scene, Claim("float32"))
    assert single.start is not None
    assert vars(single.start)["length"] == 64 * single.delta > scene.epsilon
    own = declared(scene, Claim("float32", start=0.01)).start
    assert own is not None
    assert vars(own)["length"] == 0.01


def test_a_declared_length_takes_the_place_of_the_format() -> None:
    scene = small_scene()
    claim = Claim(delta=1e-3)
    assert declared(scene, claim, most=1e-3).delta == 1e-3
    assert "declared: δ = 0.001" in declared(scene, claim).derivation
    with pytest.raises(InputError, match="wider than allowed"):
        declared(scene, claim, most=0.9e-3)
    with pytest.raises(InputError, match="wider than allowed"):
        declared(scene, Claim("float32"), most=1e-9)


def test_light_too_faint_for_halfs_relative_error_may_be_off_by_half_its_steps() -> None:
    document = small_scene("faint").to_dict()
    document["light"] |= {"color": [2e-6, 3e-6, 5e-6]}
    document["background"] = [3e-7, 5e-7, 7e-7]
    scene = minirt.load_scene(document)
    as_half = judged(scene, Claim("half", handed="half"), "half")
    (color,) = (check for check in as_half.checks if check.quantity == "color")
    assert (color.state, color.wrong) == ("passed", 0)
    assert color.ratio is not None
    assert color.ratio > 0.3


@pytest.mark.parametrize("length", [np.inf, np.nan, -1.0])
@pytest.mark.parametrize("option", ["delta", "start", "max-delta"])
def test_a_claim_that_is_no_length_is_refused(option: str, length: float) -> None:
    claim = Claim(
        delta=length if option == "delta" else 1e-3, start=length if option == "start" else None
    )
    with pytest.raises(InputError, match=f"--{option}: not a length"):
        declared(small_scene(), claim, most=length if option == "max-delta" else None)
