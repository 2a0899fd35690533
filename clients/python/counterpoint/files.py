"""Files of a job: each has a name in the job, and content identified by its digest."""

import hashlib
import pathlib
from typing import Dict, Iterable, List, Mapping, Sequence, Tuple, Union

from .settings import StrPath

#: Paths, or contents by name.
Files = Union[Sequence[StrPath], Mapping[str, bytes]]


class Pack:
    """The files of a job: contents by digest, digests by name."""

    def __init__(self) -> None:
        self.contents: Dict[str, bytes] = {}
        self.digests: Dict[str, str] = {}

    def programs(self, programs: Files) -> List[str]:
        """Adds programs; returns the name of each. A path may be given for several channels.

        Raises ValueError if a program is empty.
        """
        given = named(programs)
        for name, data in given:
            if isinstance(data, bytes) and not data.strip():
                raise ValueError(f"'{name}' is empty: a program needs at least one block")
        return self._add(given)

    def others(self, files: Files) -> None:
        """Adds files that the programs call; a folder adds its own files, but not those of its subfolders."""
        if isinstance(files, Mapping):
            self._add(files.items())
            return
        paths: List[pathlib.Path] = []
        for path in map(pathlib.Path, files):
            paths += sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
        self._add(named(paths))

    def _add(self, files: Iterable[Tuple[str, bytes]]) -> List[str]:
        names = []
        for name, data in files:
            if isinstance(data, str):
                raise TypeError(f"the content of {name} is text: give bytes, for example with .encode()")
            digest = hashlib.sha256(data).hexdigest()
            if self.digests.setdefault(name, digest) != digest:
                raise ValueError(f"two files are named {name} and differ: rename one of them")
            self.contents[digest] = data
            names.append(name)
        return names


def named(files: Files) -> List[Tuple[str, bytes]]:
    """Names and contents, in order."""
    if isinstance(files, (str, bytes)):
        raise TypeError(f"{files!r} is one path: give a list of paths")
    if isinstance(files, Mapping):
        return list(files.items())
    paths = [pathlib.Path(path) for path in files]
    return [(path.name, path.read_bytes()) for path in paths]
