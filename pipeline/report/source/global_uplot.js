// Replaces the package uplot in the pages' programs (build.mjs), because pages load uplot_program.js before them.
export default window.uPlot;
