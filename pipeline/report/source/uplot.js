// uPlot as a global, for the programs of all pages, and the style that the pages share.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import './page.css';

window.uPlot = uPlot;
