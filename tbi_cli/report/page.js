// Draws the interactive figures one after the other, so that the page stays responsive while it loads.
"use strict";
(function () {
  const plots = Array.from(document.querySelectorAll(".plot"));
  const config = {responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d"]};
  function next() {
    const plot = plots.shift();
    if (!plot) {
      document.documentElement.dataset.drawn = "all";
      return;
    }
    const figure = JSON.parse(document.getElementById(plot.dataset.from).textContent);
    Plotly.newPlot(plot, figure.data, figure.layout, config).then(function () { setTimeout(next, 0); });
  }
  next();
})();
