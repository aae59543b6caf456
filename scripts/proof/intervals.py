"""Shares and means with their 95 % intervals, and how far probabilities can be trusted."""
import math
import random

Z = 1.959963984540054


def wilson(hits, count):
    """(low, high) of a share."""
    if count == 0:
        return 0.0, 1.0
    p, z2 = hits / count, Z * Z
    middle, half = p + z2 / (2 * count), Z * math.sqrt(p * (1 - p) / count + z2 / (4 * count * count))
    return max(0.0, (middle - half) / (1 + z2 / count)), min(1.0, (middle + half) / (1 + z2 / count))


def mean(values):
    return sum(values) / len(values) if values else math.nan


def quantile(values, share):
    """Linear between order statistics."""
    if not values:
        return math.nan
    ordered = sorted(values)
    at = share * (len(ordered) - 1)
    low = int(math.floor(at))
    return ordered[low] + (at - low) * (ordered[min(low + 1, len(ordered) - 1)] - ordered[low])


def median(values):
    return quantile(values, 0.5)


def bootstrap(groups, statistic, rounds=2000, seed=1):
    """(low, high) of statistic(list of values) where whole groups (cases) are drawn anew; groups: lists of values."""
    groups = [g for g in groups if g]
    if not groups:
        return math.nan, math.nan
    rng = random.Random(seed)
    drawn = sorted(statistic([v for _ in groups for v in rng.choice(groups)]) for _ in range(rounds))
    return quantile(drawn, 0.025), quantile(drawn, 0.975)


def reliability(said, edges=(0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.97, 1.0001)):
    """[(mean probability, hits, count)] by bins. said: [(probability, whether it was right)]."""
    bins = []
    for low, high in zip(edges[:-1], edges[1:]):
        own = [(p, right) for p, right in said if low <= p < high]
        if own:
            bins.append((mean([p for p, _ in own]), sum(right for _, right in own), len(own)))
    return bins
