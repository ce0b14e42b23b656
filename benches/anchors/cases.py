"""A retrieval by CBRkit over the behaviour cases of a file, the last of which is what is asked for."""

import json
import sys
import time

import cbrkit

SCALES = {
    "translation_mps": 1.0,
    "rotation_radps": 2.0,
    "short_term_goal_distance_m": 15.0,
    "short_term_goal_bearing_rad": 3.141592653589793,
}


def similarity(scale):
    return lambda one, other: 1.0 - min(abs(one - other) / scale, 1.0)


def of_ranges(one, other):
    return 1.0 - sum(abs(a - b) for a, b in zip(one, other)) / (5.0 * len(one))


with open(sys.argv[1]) as lines:
    next(lines)
    indices = [json.loads(line)["index"] for line in lines]
asked = indices.pop()
attributes = {name: similarity(scale) for name, scale in SCALES.items()}
attributes |= {"sonars_m": of_ranges, "mean_sonars_m": of_ranges}
cases = {number: {name: index[name] for name in attributes} for number, index in enumerate(indices)}
query = {name: asked[name] for name in attributes}
retriever = cbrkit.retrieval.build(
    cbrkit.sim.attribute_value(attributes=attributes, aggregator=cbrkit.sim.aggregator(pooling="mean")),
)
apply = getattr(cbrkit.retrieval, "apply_query", None) or cbrkit.retrieval.apply
times = []
for _ in range(3):
    began = time.perf_counter()
    found = apply(cases, query, retriever)
    times.append((time.perf_counter() - began) * 1e3)
    assert len(found.ranking) == len(cases)
print(sorted(times)[1])
