"""``graphtex demo``: a first picture."""

from pathlib import Path

from graphtex.cli.terminal import DONE, say

GRAPH = "perspective/feature-mask"


def demo(*, out: Path = Path("graphtex-out/demo"), quiet: bool = False) -> int:
    """Make a first picture: run perspective/feature-mask on its sample.

    Parameters
    ----------
    out
        The folder to write to, by default graphtex-out/demo.
    quiet
        Tell nothing of the progress; warnings are told.
    """
    from graphtex.cli.arguments import read_graph
    from graphtex.cli.run import Job, carry_out

    status = carry_out(Job(read_graph(GRAPH), out, quiet=quiet))
    if status == DONE:
        say(f"The pictures are in {out}. image is the new texture: it has the texture elements of the exemplar, which")
        say("shrink with distance as there; the other pictures are maps on the way. Try next:")
        for command, what in (
            (f"run {GRAPH} --set exemplar=PHOTO.png", "your own photo of a texture on a plane"),
            (f"show {GRAPH} -o graph.svg", "how it is wired"),
            ("graphs", "what else ships"),
        ):
            say(f"  {f'graphtex {command}':65}{what}")
    return status
