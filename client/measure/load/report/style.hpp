#pragma once
// The style sheet of a load's page, for light and dark screens.

namespace collided::cli::load {

inline constexpr auto kStyle = R"css(
:root { color-scheme: light dark; --page: #fbfbfa; --card: #ffffff; --ink: #1c1e21; --quiet: #666b73; --rule: #e3e4e6;
  --line0: #2563c9; --line1: #c9561a; --line2: #1f8a5b; --alarm: #b3261e; --alarm-page: #fdeeec; }
@media (prefers-color-scheme: dark) {
  :root { --page: #15171a; --card: #1d2024; --ink: #e6e8eb; --quiet: #9aa1ab; --rule: #33383f;
    --line0: #74a7ff; --line1: #ff9a5c; --line2: #5bc895; --alarm: #ff9c92; --alarm-page: #3a1f1d; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1120px; padding: 28px 20px 48px; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", Roboto, Helvetica, Arial, sans-serif; }
h1 { font-size: 24px; margin: 0 0 4px; } h2 { font-size: 17px; margin: 32px 0 10px; }
p { margin: 0 0 4px; color: var(--quiet); }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(130px, 1fr)); gap: 12px; margin: 22px 0; }
.figures div, figure, .table { background: var(--card); border: 1px solid var(--rule); border-radius: 8px; }
.figures div { padding: 12px 14px; } .figures b { display: block; font-size: 21px; font-weight: 600; }
.figures span { color: var(--quiet); font-size: 13px; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(500px, 100%), 1fr)); gap: 14px; }
figure { margin: 0; padding: 14px 12px 8px; } svg { width: 100%; height: auto; display: block; }
svg text { font-size: 12px; fill: var(--quiet); } svg text.title { fill: var(--ink); font-size: 14px; font-weight: 600; }
svg .grid { stroke: var(--rule); } svg .bound { stroke: var(--quiet); stroke-dasharray: 5 4; }
svg polyline { fill: none; stroke-width: 2; stroke-linejoin: round; } svg line { stroke-width: 1; }
svg .line0 { stroke: var(--line0); } svg circle.line0 { fill: var(--line0); }
svg .line1 { stroke: var(--line1); } svg circle.line1 { fill: var(--line1); }
svg .line2 { stroke: var(--line2); } svg circle.line2 { fill: var(--line2); }
svg line.line0, svg line.line1, svg line.line2 { stroke-width: 3; }
.table { overflow-x: auto; padding: 4px 14px; } table { border-collapse: collapse; width: 100%; }
th, td { padding: 6px 10px; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--rule); }
tr:last-child td { border-bottom: 0; } th { color: var(--quiet); font-weight: 500; font-size: 13px; }
th:first-child, td:first-child { text-align: left; padding-left: 0; } td { font-variant-numeric: tabular-nums; }
td.words { text-align: left; white-space: normal; }
.warning { background: var(--alarm-page); color: var(--alarm); border-radius: 8px; padding: 10px 14px; margin: 12px 0 0; }
)css";

}  // namespace collided::cli::load
