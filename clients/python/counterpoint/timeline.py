"""The timeline of a job, and a drawing of it without other packages."""

from html import escape
from typing import Any, List, Mapping, NamedTuple

COLOURS = {
    "rapid": "#d55e00",
    "feed": "#0072b2",
    "tool": "#8f4d9f",
    "dwell": "#e69f00",
    "misc": "#7f8a93",
    "wait": "#d8dee4",
}


class Bar(NamedTuple):
    """Time that a channel spent on one kind of work, with the lines of its blocks in the user's program."""

    kind: str
    start_s: float
    duration_s: float
    file: str
    line: int
    end_line: int
    label: str


class Channel(NamedTuple):
    """The bars of a channel."""

    number: int
    name: str
    bars: List[Bar]

    def seconds(self, kind: str) -> float:
        """Simulated time that went into a kind of work."""
        return sum(bar.duration_s for bar in self.bars if bar.kind == kind)


class Timeline(NamedTuple):
    """Bars of all channels over simulated time."""

    makespan_s: float
    channels: List[Channel]

    @staticmethod
    def of(data: Mapping[str, Any]) -> "Timeline":
        """From timeline.json."""

        def bar(bar: Mapping[str, Any]) -> Bar:
            place = bar.get("file", ""), bar["line"], bar["end_line"]
            return Bar(bar["kind"], bar["t_ns"] / 1e9, bar["dur_ns"] / 1e9, *place, bar.get("label", ""))

        channels = [Channel(c["channel"], c["name"], [bar(b) for b in c["bars"]]) for c in data["channels"]]
        return Timeline(data["makespan_ns"] / 1e9, channels)


def draw(timeline: Timeline, width: int = 960) -> str:
    """The timeline as SVG: a row for each channel, a colour for each kind of work."""
    left, row, top = 90, 34, 34
    height = top + row * len(timeline.channels) + 34
    scale = (width - left - 34) / max(timeline.makespan_s, 1e-9)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
    ]
    x = left
    for kind, colour in COLOURS.items():
        out.append(f'<rect x="{x}" y="10" width="12" height="12" fill="{colour}"/><text x="{x + 17}" y="20">{kind}</text>')
        x += 72
    for n, channel in enumerate(timeline.channels):
        y = top + n * row
        out.append(f'<text x="{left - 8}" y="{y + 17}" text-anchor="end">{escape(channel.name)}</text>')
        for bar in channel.bars:
            start, length = left + bar.start_s * scale, max(bar.duration_s * scale, 0.3)
            title = escape(f"{bar.kind} {bar.label} {bar.file}:{bar.line}: {bar.duration_s:.3f} s")
            out.append(
                f'<rect x="{start:.1f}" y="{y}" width="{length:.1f}" height="{row - 10}" '
                f'fill="{COLOURS.get(bar.kind, "#999")}"><title>{title}</title></rect>'
            )
    for n in range(5):
        at = left + n * (width - left - 34) / 4
        out.append(f'<text x="{at:.0f}" y="{height - 10}" text-anchor="middle">{timeline.makespan_s * n / 4:.1f} s</text>')
    return "\n".join(out) + "\n</svg>\n"
