"""What the units of the SaarCOR chip do, cycle by cycle (CH-18). With --work, each run's answer ends with it."""

STALLS = {"looks up": 1, "asks": 2, "parked": 3, "waits": 4}
HOST, IDLE = 5, 6


class Work:
    """Of the units of each type the cycles in which they are busy, wait for look-up, port, register, memory and
    host, and are idle; and their operations and rays."""

    def __init__(self):
        self.counts = {unit: [0] * 9 for unit in "snlt"}

    def __str__(self):
        return ",".join("/".join(f"{count:x}" for count in counts) for counts in self.counts.values())

    def begins(self, unit, rays):
        self.counts[unit][7] += 1
        self.counts[unit][8] += rays

    def account(self, chip):
        """Rays go in, or the unit is stalled by the first cause that holds for a thread, or it is idle."""
        from_host = [part[0] for load in chip.bus.loads for part, _ in load.waiting]
        causes = {}
        for thread in chip.threads:
            if thread.state in STALLS:
                cause = HOST if thread.state == "waits" and thread.way in from_host else STALLS[thread.state]
                place = thread.pipeline, thread.program[0][0]
                causes[place] = min(cause, causes.get(place, cause))
        for pipeline in range(chip.config["pipelines"]):
            for unit, counts in self.counts.items():
                is_busy = chip.units.get((pipeline, unit), (-1, 0))[1] > chip.now
                counts[0 if is_busy else causes.get((pipeline, unit), IDLE)] += 1
