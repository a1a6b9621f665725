"""The imports between the modules of homebot: also those inside functions and for type checkers."""

from functools import cache

import grimp


@cache
def import_graph() -> dict[str, frozenset[str]]:
    """Return the modules of homebot that each module imports."""
    graph = grimp.build_graph("homebot", exclude_type_checking_imports=False, cache_dir=None)
    return {module: frozenset(graph.find_modules_directly_imported_by(module)) for module in graph.modules}
