"""The JSON Schema of a scenario, for editors that complete and check TOML files."""

from __future__ import annotations

import json
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from testbed.scenario.cluster import NO_CLUSTER
from testbed.scenario.scenario import ACTUATORS, NEEDED_TO_FLY, Scenario


class _TomlSchema(GenerateJsonSchema):
    """TOML has no null: what may be None in Python is a key that may be left out of the file."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        if self.get_default_value(schema) in (None, NO_CLUSTER):
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)

    def encode_default(self, dft: object) -> object:
        return {} if isinstance(dft, BaseModel) else super().encode_default(dft)

    def field_title_should_be_set(self, schema: object) -> bool:  # noqa: ARG002 - a key is its own title
        return False


def scenario_schema() -> dict[str, Any]:
    """Return the JSON Schema of a scenario: of one that can be flown, or of one without any section of a flight."""
    schema = schema_of(Scenario)
    required = [key for key in schema["required"] if key not in NEEDED_TO_FLY]
    dependent = {key: sorted(NEEDED_TO_FLY - {key}) for key in sorted(NEEDED_TO_FLY)}
    any_actuator = {"anyOf": [{"required": [key]} for key in ACTUATORS]}
    return {
        "$schema": _TomlSchema.schema_dialect,
        **schema,
        "required": required,
        "dependentRequired": dependent,
        "dependentSchemas": dict.fromkeys(sorted(NEEDED_TO_FLY), any_actuator),
    }


def schema_of(form: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON Schema of a file that is one section."""
    return form.model_json_schema(schema_generator=_TomlSchema)


def schema_text() -> str:
    """Return the contents of docs/scenario.schema.json."""
    return json.dumps(scenario_schema(), indent=2, ensure_ascii=False) + "\n"
