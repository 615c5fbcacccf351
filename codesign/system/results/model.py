"""The base of every record of figures."""

from pydantic import BaseModel, ConfigDict

from codesign.ground.errors import clip

_MOST_LETTERS = 1000


class ResultModel(BaseModel):
    """A frozen record without further keys. Its JSON Schema requires every field, as its JSON has them all.

    Its ``repr`` is cut; ``model_dump`` gives all of it.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", json_schema_serialization_defaults_required=True, defer_build=True
    )

    def __repr__(self) -> str:
        return clip(super().__repr__(), _MOST_LETTERS)
