"""Reads metrics with Prometheus' own client library, and holds them to its rules."""
import sys

from prometheus_client.parser import text_string_to_metric_families

with open(sys.argv[1]) as source:
    families = list(text_string_to_metric_families(source.read()))
names = [family.name for family in families]
assert len(names) == len(set(names)), "a family comes twice"
for family in families:
    assert family.documentation, family.name
    assert family.type in ("gauge", "counter", "histogram"), (family.name, family.type)
    if family.type == "histogram":
        counts = [sample.value for sample in family.samples if sample.name.endswith("_bucket")]
        assert counts == sorted(counts) and len(counts) > 10, family.name
for wanted in ("tissued_latency_seconds", "tissued_events", "tissued_alarm_raised", "tissued_innovation_rms_mm"):
    assert wanted in names, wanted
