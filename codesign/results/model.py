"""The base of every record of figures."""

from pydantic import BaseModel, ConfigDict


class ResultModel(BaseModel):
    """A frozen record without further keys. Its JSON Schema requires every field, as its JSON has them all."""

    model_config = ConfigDict(frozen=True, extra="forbid", json_schema_serialization_defaults_required=True)
