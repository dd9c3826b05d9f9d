#include "pipeline/charts/chart_page.hpp"

#include <fmt/format.h>

#include "error/plain_cell.hpp"

namespace borelli {
namespace {

constexpr const char* style = R"(
body{font:15px/1.45 Helvetica,Arial,'DejaVu Sans',sans-serif;color:#111;max-width:780px;margin:2em auto;padding:0 1em}
h1{font-size:1.5em} h2{font-size:1.15em;margin-top:2em} svg{max-width:100%;height:auto;display:block}
nav{display:flex;flex-wrap:wrap;gap:.4em;margin:.6em 0} button{font:inherit;padding:.25em .7em;border:1px solid #888;
background:#fff;border-radius:4px;cursor:pointer} button[aria-pressed=true]{background:#0072B2;border-color:#0072B2;color:#fff}
table{border-collapse:collapse;margin:.5em 0} td,th{padding:.2em .8em .2em 0;text-align:left;vertical-align:top}
th{border-bottom:1px solid #888} td.n,th.n{text-align:right;white-space:nowrap} .plot[hidden]{display:none}
[data-names]{cursor:pointer} .warning{border-left:4px solid #D55E00;padding-left:.7em}
.off{opacity:.3} #tip{position:fixed;background:#fff;border:1px solid #888;padding:.35em .6em;
font-size:13px;white-space:pre-line;pointer-events:none;max-width:28em;border-radius:4px;box-shadow:0 1px 5px #0003}
@media print{nav{display:none} .plot[hidden]{display:block}})";

constexpr const char* script = R"(
const plots=[...document.querySelectorAll('.plot')],tip=document.getElementById('tip');
const chosen={};
function show(){for(const p of plots)p.hidden=Object.keys(chosen).some(k=>p.dataset[k]!==chosen[k]);
for(const b of document.querySelectorAll('nav button'))b.setAttribute('aria-pressed',chosen[b.dataset.kind]===b.dataset.value)}
for(const b of document.querySelectorAll('nav button')){chosen[b.dataset.kind]??=b.dataset.value;
b.onclick=()=>{chosen[b.dataset.kind]=b.dataset.value;show()}}
show();
for(const e of document.querySelectorAll('[data-curve] title')){const m=e.parentNode,text=e.textContent;e.remove();
m.onmousemove=v=>{tip.textContent=text;tip.hidden=false;tip.style.left=Math.min(v.clientX+14,innerWidth-tip.offsetWidth-8)+'px';
tip.style.top=Math.min(v.clientY+14,innerHeight-tip.offsetHeight-8)+'px'};m.onmouseleave=()=>{tip.hidden=true}}
for(const l of document.querySelectorAll('[data-names]'))l.onclick=()=>{const off=l.classList.toggle('off');
for(const c of l.closest('svg').querySelectorAll('[data-curve]'))if(c.dataset.curve===l.dataset.names)c.style.display=off?'none':''};
)";

}  // namespace

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += c == '&'   ? "&amp;"
           : c == '<' ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

std::string csv_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : plain_cell(text)) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + '"';
}

std::string chart_page(std::string_view title, std::string_view heading,
                       const std::vector<std::string>& warnings, const std::vector<std::string>& sentences,
                       const std::vector<PageButtons>& buttons, std::string_view body) {
  std::string out = fmt::format(
      "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>{}<meta name='viewport' "
      "content='width=device-width'><title>{}</title><style>{}</style></head><body>\n<h1>{}</h1>\n",
      page_policy, html_text(title), style, html_text(heading));
  for (const std::string& warning : warnings)
    out += "<p class='warning'>Warning: " + html_text(warning) + "</p>\n";
  for (const std::string& sentence : sentences) out += "<p>" + html_text(sentence) + "</p>\n";
  for (const PageButtons& row : buttons) {
    out += "<nav>";
    for (const auto& [value, says] : row.values)
      out +=
          fmt::format("<button data-kind='{}' data-value='{}'>{}</button>", row.kind, value, html_text(says));
    out += "</nav>\n";
  }
  out += body;
  return out + fmt::format("<div id='tip' hidden></div><script>{}</script></body></html>\n", script);
}

}  // namespace borelli
