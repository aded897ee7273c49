"""No module imports itself by way of others, not even inside a function or for types alone."""

from graphlib import CycleError, TopologicalSorter

import grimp


def test_imports_run_in_no_circle():
    """The modules can be put in an order in which each imports only those before it."""
    graph = grimp.build_graph("geometry", "tmm", "fem", "validation", cache_dir=None)
    sorter = TopologicalSorter(
        {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    )
    try:
        sorter.prepare()
    except CycleError as circle:
        raise AssertionError(f"these modules import each other: {circle.args[1]}") from None
