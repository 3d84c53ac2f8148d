"""Whether what was measured at the low points of the tides grows."""

import math

RSS_PERCENT = 1.0  # of its mean, in 100 tides
UNRETURNED = {  # bytes that are freed, and counted none the less: so much more in all tides is no growth
    "rss": 8 << 20,  # what the daemon does not give back to the system, so that rss has steps
    "heap": 1 << 20,  # what the allocator keeps for each thread, and the last scenes that ended, whose ends can be asked for
}
LEAST_TIDES = 9  # fewer tell nothing
POOLED = ("fds", "threads")  # gRPC's pools keep a few threads, and their descriptors, more or less when all are gone:
POOL = 1.0  # so much in all tides is no growth; what each tide keeps is
POOL_STEP = 0.25  # of a pool: it may step up by no more than that
CERTAIN = 3.0  # standard errors: what is called growth is not noise


def slope(values):
    """Least squares over 0, 1, ...: the slope, and its standard error, widened for neighbours that resemble each other."""
    count = len(values)
    if count < 3:
        return 0.0, math.inf
    middle, mean = (count - 1) / 2, sum(values) / count
    spread = sum((i - middle) ** 2 for i in range(count))
    out = sum((i - middle) * (value - mean) for i, value in enumerate(values)) / spread
    rest = [value - mean - out * (i - middle) for i, value in enumerate(values)]
    squares = sum(r * r for r in rest)
    error = math.sqrt(squares / (count - 2) / spread)
    lag = sum(a * b for a, b in zip(rest, rest[1:])) / squares if squares else 0.0
    lag = min(max(lag, 0.0), 0.9)
    return out, error * math.sqrt((1 + lag) / (1 - lag))


def after_warm_up(tides):
    return tides[len(tides) // 3:]


def verdict(tides):
    """Slopes of each measure in a tide, and complaints; none if nothing grows. tides: dicts of measures, in their order."""
    kept = after_warm_up(tides)
    slopes, complaints = {}, []
    if len(tides) < LEAST_TIDES:
        return slopes, [f"{len(tides)} tides are too few to tell"]
    for name in kept[0]:
        values = [tide[name] for tide in kept]
        grows, error = slope(values)
        slopes[name] = {"per_tide": grows, "standard_error": error, "first": values[0], "last": values[-1]}
        if name in UNRETURNED:
            allowed = RSS_PERCENT / 100 * sum(tide["rss"] for tide in kept) / len(kept) / 100 + UNRETURNED[name] / (len(values) - 1)
            if grows - CERTAIN * error > allowed:
                complaints.append(f"{name} grows by {grows:.0f} +- {error:.0f} bytes in a tide; {allowed:.0f} are allowed")
        elif name in POOLED:
            if (grows - CERTAIN * error) * (len(values) - 1) > POOL:
                complaints.append(f"{name} grow by {grows:.2f} +- {error:.2f} in a tide: {values}")
            half = (len(values) + 1) // 2
            if max(values[half:]) > max(values[:half]) * (1 + POOL_STEP):
                complaints.append(f"{name} go much higher in the second half of the tides than in the first: {values}")
        elif any(value != values[0] for value in values):
            complaints.append(f"{name} is not what it was at the first low point after the warm-up: {values}")
    return slopes, complaints
