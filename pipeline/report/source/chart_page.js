// The program of a page of charts (borelli chart, stability, economy): draws the plots that page_plots.cpp wrote into
// the page, and shows those that the buttons choose.
import './chart_page.css';
import { darkScheme, onResize } from './dom.js';
import { makePlot } from './plot.js';

const { tips, plots } = JSON.parse(document.getElementById('plots').textContent);
const figures = [...document.querySelectorAll('.plot')];
const rows = [...document.querySelectorAll('.choices')];
const made = figures.map((figure, i) => {
  const plot = makePlot(plots[i], tips);
  figure.prepend(plot.element);
  onResize(figure, plot.draw);
  return plot;
});
const chosen = {};

function show() {
  figures.forEach((figure, i) => {
    figure.hidden = Object.entries(chosen).some(([kind, value]) => figure.dataset[kind] !== value);
    if (!figure.hidden) made[i].draw();
  });
  for (const row of rows)
    for (const button of row.querySelectorAll('button'))
      button.setAttribute('aria-pressed', String(button.value === chosen[row.dataset.kind]));
}

document.documentElement.classList.add('live-charts');
for (const row of rows) {
  row.hidden = false;
  const choose = ({ currentTarget }) => {
    chosen[row.dataset.kind] = currentTarget.value;
    show();
  };
  const select = row.querySelector('select');
  select?.addEventListener('change', choose);
  for (const button of row.querySelectorAll('button')) button.addEventListener('click', choose);
  chosen[row.dataset.kind] = (select ?? row.querySelector('button')).value;
}
show();
darkScheme.addEventListener('change', show);

// for tests: the plots in page order
window.borelli = { ready: Promise.resolve(), plots: made };
