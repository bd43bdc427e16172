"""Style and script of the report; the page works without the script, only keys and closing by a click need it."""

from graphtex.show.style import STATUS_COLOURS

_LIGHT = ";".join(f"--{status}:{light}" for status, (light, _) in STATUS_COLOURS.items())
_DARK = ";".join(f"--{status}:{dark}" for status, (_, dark) in STATUS_COLOURS.items())

STYLE = f"""
:root{{{_LIGHT}}}
@media(prefers-color-scheme:dark){{:root{{{_DARK}}}}}
{"".join(f".{status}{{--tone:var(--{status})}}" for status in STATUS_COLOURS)}
.chip{{display:inline-block;font:600 .75rem/1.5 system-ui,sans-serif;padding:0 .5em;border:1px solid var(--tone);
border-radius:1em;color:var(--tone);vertical-align:.12em;white-space:nowrap}}
.message{{border-left:3px solid var(--tone);padding:.4rem .8rem;background:var(--soft)}}
.group{{border-top:1px solid var(--line);margin-top:2.2rem}}
.group>h2{{margin-top:1.1rem}}
dl{{display:flex;flex-wrap:wrap;gap:.5rem 2rem;margin:.8rem 0;font-size:.9rem}}
dl div{{min-width:0}} dt{{color:var(--dim);font-size:.8rem}} dd{{margin:0;overflow-wrap:anywhere}}
.views{{display:flex;flex-wrap:wrap;gap:1rem;align-items:flex-start;margin:.8rem 0}}
.grid{{display:grid;grid-template-columns:repeat(auto-fill,minmax(9rem,1fr))}}
.outputs{{display:flex;flex-wrap:wrap;gap:0 2.5rem}} .output{{max-width:100%;min-width:0}} .wide{{flex-basis:100%}}
figure{{margin:0;max-width:100%;min-width:0}}
figcaption{{font-size:.8rem;line-height:1.4;margin-top:.25rem;max-width:26rem;overflow-wrap:anywhere}}
img{{display:block;max-width:100%;height:auto;
background:repeating-conic-gradient(#d5d8dc 0 25%,#fff 0 50%) 0 0/16px 16px}}
img.tiny{{image-rendering:pixelated}}
.told,.gap{{padding:.7rem .9rem;border:1px solid var(--line);border-radius:4px;font-size:.9rem;overflow-wrap:anywhere}}
.gap{{border-color:var(--failed);color:var(--failed)}}
.gap,.told{{max-width:26rem}}
.zoom{{display:inline-block;max-width:100%;cursor:zoom-in}} .close{{display:none}}
.zoom:target,.zoom.open{{position:fixed;inset:0;z-index:9;max-width:none;display:grid;place-items:center;cursor:zoom-out;
background:rgb(12 14 16/.93)}}
.zoom:target img,.zoom.open img{{width:96vw;height:94vh;object-fit:contain;image-rendering:pixelated;background:none}}
.zoom:target+.close,.zoom.open+.close{{display:block;position:fixed;top:.6rem;right:.6rem;z-index:10;width:2.5rem;
height:2.5rem;font-size:1.5rem;line-height:2.4rem;text-align:center;text-decoration:none;color:#fff;background:#33383f;
border-radius:50%}}
.task{{border:1px solid var(--line);border-radius:6px;margin:.4rem 0;padding:0 .9rem}}
.task[open]{{padding-bottom:.9rem}}
.task>summary{{padding:.45rem 0;cursor:pointer;overflow-wrap:anywhere}}
.matrix td,.matrix th{{padding:.3rem .5rem .3rem 0;border:0}} .matrix figcaption{{max-width:10rem}}
.matrix .gap,.matrix .told{{width:9rem}} .matrix .gap,.grid .gap{{padding:.4rem .6rem;font-size:.8rem}}
.group:target,.task:target{{outline:2px solid var(--link);outline-offset:1px;border-radius:6px}}
nav ul{{columns:20rem;padding-left:1.2rem;font-size:.9rem}} ul{{margin:.4rem 0;padding-left:1.2rem}}
@media print{{.task{{break-inside:avoid}}}}
"""

SCRIPT = """
(() => {
  let open = null;
  const show = link => {
    if (open) open.classList.remove('open');
    open = link;
    if (link) { link.classList.add('open'); link.focus({preventScroll: true}); }
  };
  const unfold = () => {
    const place = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!place) return;
    for (let e = place; e; e = e.parentElement) if (e.tagName === 'DETAILS') e.open = true;
    place.scrollIntoView();
  };
  document.addEventListener('click', event => {
    const link = event.target.closest('a.zoom');
    if (link) { event.preventDefault(); show(open === link ? null : link); }
    else if (event.target.closest('a.close') && open) { event.preventDefault(); show(null); }
  });
  document.addEventListener('keydown', event => {
    if (!open) return;
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
    if (event.key === 'Escape') show(null);
    else if (step) {
      const all = [...document.querySelectorAll('a.zoom')].filter(a => a === open || a.offsetParent);
      show(all[(all.indexOf(open) + step + all.length) % all.length]);
    } else return;
    event.preventDefault();
  });
  addEventListener('hashchange', unfold);
  if (location.hash) unfold();
})();
"""
