// Stands for the package uplot in the programs of the pages (build.mjs): a page holds uplot_program.js before them.
export default window.uPlot;
