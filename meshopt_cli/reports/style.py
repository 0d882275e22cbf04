"""How pages look: in light and in dark, on a phone and on paper."""

from __future__ import annotations

STYLE = """
:root {
  color-scheme: light dark;
  --back: #ffffff; --box: #f4f6f8; --ink: #1b1f24; --faint: #57606a; --rule: #d0d7de;
  --card: #ffffff; --now: #0b5cad; --was: #8a5300; --note: #fff4d6; --note-edge: #b07d00;
}
@media (prefers-color-scheme: dark) {
  :root {
    --back: #14171a; --box: #1e2328; --ink: #e6e8ea; --faint: #a3adb8; --rule: #3a424a;
    --card: #b9c0c8; --now: #7ab8ff; --was: #e0a84f; --note: #33290f; --note-edge: #d6a32b;
  }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body {
  margin: 0 auto; padding: 1rem clamp(.75rem, 3vw, 2rem) 3rem; max-width: 72rem;
  background: var(--back); color: var(--ink);
  font: 1rem/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif;
}
h1, h2, h3 { line-height: 1.25; overflow-wrap: anywhere; margin: 0 0 .5rem; }
h1 { font-size: clamp(1.3rem, 5vw, 1.6rem); }
h2 { font-size: 1.3rem; }
h3 { font-size: 1.1rem; }
section { margin-top: 2rem; }
article { margin-top: 3rem; padding-top: 1.5rem; border-top: 2px solid var(--rule); }
article.only { margin-top: 0; padding-top: 0; border-top: 0; }
p { margin: .4rem 0; max-width: 48rem; overflow-wrap: anywhere; }
a { color: var(--now); }
.faint, figcaption, caption { color: var(--faint); font-size: .875rem; }
.scroll { overflow-x: auto; margin: .75rem 0; }
.scroll:focus-visible { outline: 2px solid var(--now); outline-offset: 2px; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .925rem; }
caption { text-align: left; padding: 0 0 .35rem; }
th, td { padding: .3rem .7rem; text-align: right; vertical-align: top; white-space: nowrap; }
th { font-weight: 600; }
thead th, thead td { border-bottom: 2px solid var(--rule); vertical-align: bottom; }
tbody th, tbody td { border-bottom: 1px solid var(--rule); }
tbody th, .words { text-align: left; }
td.long { white-space: normal; min-width: 15rem; text-align: left; }
th.long { text-align: left; }
td small { display: block; color: var(--faint); font-size: .8rem; }
tbody th, thead :first-child { padding-left: 0; }
td code { overflow-wrap: anywhere; }
code, pre { font-family: ui-monospace, "Liberation Mono", Menlo, Consolas, monospace; }
code { font-size: .85em; }
pre {
  white-space: pre-wrap; overflow-wrap: anywhere; margin: .4rem 0; padding: .6rem .8rem;
  background: var(--box); border-radius: .3rem;
}
.tiles { display: grid; gap: .6rem; grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr)); }
.tiles { margin: 1rem 0 0; }
.tiles div { background: var(--box); border-radius: .4rem; padding: .6rem .8rem; }
.tiles dt { color: var(--faint); font-size: .875rem; }
.tiles dd { margin: 0; font-size: 1.1rem; font-weight: 600; font-variant-numeric: tabular-nums; }
.tiles span { white-space: nowrap; }
.notes {
  margin: 1rem 0 0; padding: .6rem .8rem .6rem 2rem; background: var(--note);
  border-left: 4px solid var(--note-edge); border-radius: .2rem; overflow-wrap: anywhere;
}
.drawings {
  display: grid; gap: 1rem 2rem;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 22rem), 1fr));
}
figure { margin: .5rem 0; max-width: 28rem; }
.pictures { display: grid; gap: 1rem 2rem; }
.pictures { grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr)); }
figure.picture { max-width: 44rem; }
figure.legend { max-width: 24rem; }
.cells { display: grid; gap: .5rem 1rem; }
.cells { grid-template-columns: repeat(auto-fill, minmax(max(8rem, 18%), 1fr)); }
figure.cell { margin: 0; }
figure.cell img { border: 1px solid var(--rule); border-radius: .3rem; background: var(--card); }
img { display: block; width: 100%; height: auto; }
figcaption { margin-top: .25rem; overflow-wrap: anywhere; }
svg { display: block; width: 100%; height: auto; overflow: visible; }
ul { padding-left: 1.3rem; margin: .5rem 0; overflow-wrap: anywhere; }
svg text { fill: var(--ink); font-size: 12px; font-family: inherit; }
svg .name { fill: var(--faint); }
svg .now { fill: var(--now); }
svg .was { fill: transparent; stroke: var(--was); stroke-width: 1.5; }
svg .axis { fill: none; stroke: var(--faint); }
svg .grid { fill: none; stroke: var(--rule); }
svg .ideal { fill: none; stroke: var(--was); stroke-width: 1.5; stroke-dasharray: 4 3; }
svg .line { fill: none; stroke-width: 1.5; stroke-linejoin: round; }
svg .line.worst { stroke: var(--was); }
svg .line.mean { stroke: var(--now); stroke-dasharray: 5 3; }
svg circle.worst { fill: var(--was); }
svg circle.mean { fill: var(--now); }
details summary { cursor: pointer; color: var(--now); margin: .5rem 0; }
footer { margin-top: 3rem; border-top: 1px solid var(--rule); padding-top: .75rem; }
@media print {
  :root {
    --back: #ffffff; --box: #ffffff; --ink: #000000; --faint: #333333; --rule: #999999;
    --card: #ffffff; --now: #0b5cad; --was: #8a5300; --note: #ffffff; --note-edge: #555555;
  }
  body { max-width: none; padding: 0; font-size: 10pt; }
  section { margin-top: 1.2rem; }
  figure, tr, .tiles { break-inside: avoid; }
  h1, h2, h3, caption { break-after: avoid; }
  .tiles div { border: 1px solid var(--rule); }
  .scroll { overflow: visible; }
  th, td { padding: .15rem .4rem; }
  th, td, code { white-space: normal; }
  td.long { min-width: 0; }
  svg .now { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  details::details-content { content-visibility: visible; block-size: auto; }
  summary { list-style: none; }
  article + article { break-before: page; }
}
""".strip()
