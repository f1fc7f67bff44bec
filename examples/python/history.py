"""The history of a record by load steps; needs nothing."""


def load_steps(record):
    """Pairs (first, end) of entries of record["history"], one a load step."""
    count = len(record["history"])
    lengths = record["result"].get("load_step_iterations") or [
        step.get("iterations", 0) for step in record.get("steps") or []]
    if sum(lengths) != count or 0 in lengths:
        return [(0, count)] if count else []
    ends = [sum(lengths[:k + 1]) for k in range(len(lengths))]
    return list(zip([0] + ends, ends))


def final_energies(record):
    """For every load step the energy that it ended with."""
    ends = [end for _, end in load_steps(record)]
    return [record["result"]["energy"] if end == len(record["history"])
            else record["history"][end - 1]["energy"] for end in ends]
