"""validate: checks BSDF XML, Klems matrices or a tensor tree, for one reader: schema, fields, values, energy.

Findings are errors (the file is wrong), warnings (odd, or read in a way the user should know) and notes (figures).
"""

from pathlib import Path

from gonio.formats.detect import beginning_of, looks_like_xml
from gonio.formats.findings import Findings
from gonio.formats.tensor.read import is_tensor
from gonio.formats.validate import document, klems_values, tree
from gonio.formats.validate.document import Profile
from gonio.formats.window.read import read
from gonio.units.errors import UsageError

__all__ = ["Profile", "validate"]


def validate(path: Path, profile: Profile = "window") -> Findings:
    """Findings about a file for one reader: WINDOW (schema, all fields and matrices) or Radiance (what it loads).

    Raises UsageError when the file cannot be read at all: foreign, cut off, too large.
    """
    if not looks_like_xml(beginning_of(path)):
        raise UsageError(f"{path}: not readable as XML: give BSDF XML, as gonio export writes it")
    if is_tensor(path):
        return tree.validate(path, profile)
    content = read(path)
    document.check_schema(content.root, content.findings, profile)
    klems_values.check(content, profile)
    document.check_fields(content, profile)
    return content.findings
