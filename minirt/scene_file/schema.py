"""The scene file's format, version 1, as pydantic models; the published JSON Schema is theirs."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Strict,
    Tag,
    field_validator,
    model_validator,
)

#: Largest magnitude of a number in a scene; products of six such lengths stay finite in float64.
LARGEST = 1e30
#: Smallest length that does not count as zero, for the same reason.
SMALLEST = 1e-30
#: Largest image: 2**28 pixels, for example 16,384 × 16,384.
MAX_PIXELS = 2**28
#: Most columns or rows of an image.
MAX_SIDE = 2**17
#: Most generations of reflected and refracted rays.
MAX_DEPTH = 16

_Number = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
_Positive = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=SMALLEST, le=LARGEST)]
_Share = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=0, le=1)]
_Channel = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=0, le=1e6)]
_Vector = tuple[_Number, _Number, _Number]
_Color = tuple[_Channel, _Channel, _Channel]
_Side = Annotated[int, Strict(), Field(ge=1, le=MAX_SIDE)]
_Text = Annotated[str, Strict(), Field(max_length=100_000)]
_Name = Annotated[str, Strict(), Field(min_length=1, max_length=10_000)]
_Row = tuple[_Number, _Number, _Number, _Number]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class ScreenModel(_Model):
    """The virtual screen in the slides' form (S1, S2)."""

    P0: _Vector = Field(description="the observer")
    u: _Vector = Field(description="unit horizontal axis of the view plane")
    v: _Vector = Field(description="unit vertical axis of the view plane")
    n: _Vector = Field(description="unit normal of the view plane; the screen lies at P0 + nu·n")
    nu: _Number = Field(description="ν of the plane n = ν, of either sign, not 0")
    l: _Number = Field(description="left bound of the screen")
    r: _Number = Field(description="right bound of the screen, > l")
    b: _Number = Field(description="bottom bound of the screen")
    t: _Number = Field(description="top bound of the screen, > b")
    nx: _Side = Field(description="columns of pixels")
    ny: _Side = Field(description="rows of pixels")


class LookAt(_Model):
    """A camera as most programs describe it."""

    eye: _Vector
    target: _Vector
    up: _Vector
    fov_y: Annotated[float, Strict(), Field(gt=0, lt=180, allow_inf_nan=False)] = Field(
        description="full vertical angle of view in degrees"
    )


class LookAtScreenModel(_Model):
    """The virtual screen by eye, target and angle; square pixels, centred, ν = −1."""

    look_at: LookAt
    nx: _Side
    ny: _Side


class LightModel(_Model):
    """One directional light (S12)."""

    direction: _Vector = Field(description="direction of travel, of any length but 0")
    color: _Color = (1.0, 1.0, 1.0)


class MaterialModel(_Model):
    """Phong's terms, and the shares that are mirrored and let through (S7, S13–S16)."""

    ambient: _Color = (0.0, 0.0, 0.0)
    diffuse: _Color = (0.8, 0.8, 0.8)
    specular: _Color = (0.0, 0.0, 0.0)
    shininess: Annotated[int, Strict(), Field(ge=1, le=1_000_000)] = 1
    reflectance: _Share = Field(0.0, description="k_r; k_r + k_t ≤ 1")
    transmittance: _Share = Field(0.0, description="k_t; needs an ior where it is not 0")
    ior: Annotated[float, Strict(), Field(ge=1e-3, le=1e3)] | None = Field(
        None, description="refractive index relative to the outside, whose index is 1"
    )
    alpha: _Share = 1.0

    @model_validator(mode="after")
    def _shares(self) -> MaterialModel:
        if self.reflectance + self.transmittance > 1:
            raise ValueError(
                f"reflectance + transmittance is {self.reflectance + self.transmittance!r}; "
                "expected at most 1"
            )
        if self.transmittance > 0 and self.ior is None:
            raise ValueError("transmittance without an index of refraction; expected an ior")
        return self


class _ObjectModel(_Model):
    name: _Name | None = None
    material: _Name


class SphereModel(_ObjectModel):
    """S8; the normal points outward."""

    type: Literal["sphere"]
    center: _Vector
    radius: _Positive


class TriangleModel(_ObjectModel):
    """S9; the normal follows the right-hand rule of the vertices."""

    type: Literal["triangle"]
    vertices: tuple[_Vector, _Vector, _Vector]


class PolygonModel(_ObjectModel):
    """S10, S11: a convex planar polygon; one object."""

    type: Literal["polygon"]
    vertices: Annotated[list[_Vector], Field(min_length=3, max_length=100_000)]


class MeshModel(_ObjectModel):
    """Triangles from a file beside the scene; one object."""

    type: Literal["mesh"]
    file: _Name = Field(description="path relative to the scene file; may not leave its folder")
    transform: tuple[_Row, _Row, _Row, _Row] = Field(
        ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
        description="affine map from the file's coordinates, row by row; last row 0 0 0 1",
    )


ObjectModel = Annotated[
    SphereModel | TriangleModel | PolygonModel | MeshModel, Field(discriminator="type")
]


class FloorModel(_Model):
    """A delicate scene's own floor for the share of certain pixels, and why it needs one."""

    certain: _Share
    why: _Name


def _screen_form(value: Any) -> str:
    named = "look_at" in value if isinstance(value, dict) else isinstance(value, LookAtScreenModel)
    return "look_at form" if named else "slides form"


class SceneDocument(_Model):
    """One scene of minirt, format version 1."""

    minirt: Literal[1] = Field(description="version of the format")
    name: _Name
    about: _Text = Field("", description="one line: what this scene proves")
    proves: _Text = Field("", description="a paragraph: what this scene proves")
    failure_means: _Text = Field("", description="a paragraph: what a failure usually means")
    rules: list[Annotated[str, Field(pattern=r"^(S([1-9]|1[0-7])|E[1-8])$")]] = Field(
        default_factory=list, description="the rules that it exercises"
    )
    floor: FloorModel | None = None
    screen: Annotated[
        Annotated[ScreenModel, Tag("slides form")]
        | Annotated[LookAtScreenModel, Tag("look_at form")],
        Discriminator(_screen_form),
    ]
    light: LightModel
    background: _Color = (0.0, 0.0, 0.0)
    shadow_color: _Color | None = Field(None, description="null: the ambient term alone")
    epsilon: _Positive | None = Field(None, description="a length; null: 1e-6 × the scene's extent")
    max_depth: Annotated[int, Strict(), Field(ge=0, le=MAX_DEPTH)] = Field(
        5, description="generations of reflected and refracted rays"
    )
    materials: dict[_Name, MaterialModel]
    objects: Annotated[list[ObjectModel], Field(max_length=1_000_000)]

    @field_validator("minirt", mode="before")
    @classmethod
    def _version(cls, value: Any) -> Any:
        if isinstance(value, bool):  # Python's True equals 1
            raise ValueError("not a version of the format; expected 1")
        return value


def key_names(place: tuple[int | str, ...]) -> tuple[str, ...]:
    """The keys that are allowed in the JSON object at a place, which is pydantic's `loc`.

    Examples
    --------
    >>> key_names(("objects", 2, "sphere"))
    ('name', 'material', 'type', 'center', 'radius')
    """
    model: type[BaseModel] = SceneDocument
    match place:
        case ("screen", form, *below):
            slides = form == "slides form"
            model = LookAt if below else ScreenModel if slides else LookAtScreenModel
        case ("objects", _, kind):
            kinds: dict[object, type[BaseModel]] = {
                "sphere": SphereModel, "triangle": TriangleModel,
                "polygon": PolygonModel, "mesh": MeshModel,
            }  # fmt: skip
            model = kinds[kind]
        case ("materials", _):
            model = MaterialModel
        case ("light",):
            model = LightModel
        case ("floor",):
            model = FloorModel
    return tuple(model.model_fields)


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of a scene file, draft 2020-12.

    It says what each key may hold. What joins several keys (an orthonormal frame, a material's
    name, a convex polygon, a mesh's file) is checked on loading.

    Examples
    --------
    >>> scene_schema()["title"]
    'A scene of minirt, format version 1'
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **SceneDocument.model_json_schema(),
        "title": "A scene of minirt, format version 1",
    }
