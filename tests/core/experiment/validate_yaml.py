#!/usr/bin/env python3
"""Validates YAML files against a JSON Schema, as an editor does.

usage: validate_yaml.py SCHEMA FILE...

Prints a line a file: its name, then OK, or the path of the deepest fault and what is wrong.
YAML is read by the rules of version 1.2's core schema, as editors read it: PyYAML's own are those of
1.1, where 2e-5 is a text and `yes` is true.
"""
import json
import re
import sys

import jsonschema
import yaml


class Loader(yaml.SafeLoader):
    yaml_implicit_resolvers = {}


def resolver(kind, pattern, first):
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{kind}", re.compile(pattern), list(first))


resolver("null", r"^(~|null|Null|NULL|)$", ["~", "n", "N", ""])
resolver("bool", r"^(true|True|TRUE|false|False|FALSE)$", "tTfF")
resolver("int", r"^[-+]?[0-9]+$", "-+0123456789")
resolver(
    "float",
    r"^([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$",
    "-+.0123456789",
)
Loader.add_constructor(
    "tag:yaml.org,2002:int", lambda loader, node: int(loader.construct_scalar(node))
)


def deepest(error):
    """What is wrong in the branch that the file comes nearest to."""
    while error.context:
        error = max(error.context, key=lambda inner: len(inner.absolute_path))
    return error


def main(schema_file, files):
    with open(schema_file) as stream:
        schema = json.load(stream)
    jsonschema.Draft7Validator.check_schema(schema)
    validator = jsonschema.Draft7Validator(schema)
    for file in files:
        with open(file) as stream:
            document = yaml.load(stream, Loader)
        errors = [deepest(error) for error in validator.iter_errors(document)]
        if not errors:
            print(file, "OK")
            continue
        error = max(errors, key=lambda one: len(one.absolute_path))
        path = ".".join(str(part) for part in error.absolute_path)
        print(file, f"{path}: {error.message}".replace("\n", " ")[:300])


main(sys.argv[1], sys.argv[2:])
