(() => {
  "use strict";
  const ON_PAPER = { width: 680, height: 255 }; // px: fits A4 and US letter, three charts to a page
  const CONFIG = {
    responsive: true, displaylogo: false, doubleClick: "reset",
    modeBarButtons: [["zoom2d", "pan2d", "resetScale2d", "toImage"]],
  };
  const charts = [...document.querySelectorAll(".chart")].map((node) => ({
    node, ...JSON.parse(node.nextElementSibling.textContent),
  }));
  const linked = charts.filter(({ node }) => "sharesTime" in node.dataset).map(({ node }) => node);

  // Colours are named in the charts and looked up when they are drawn.
  function coloured(value, style) {
    if (typeof value === "string" && value.startsWith("var(")) return style.getPropertyValue(value.slice(4, -1)).trim();
    if (Array.isArray(value)) return value.map((item) => coloured(item, style));
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, coloured(item, style)]));
  }

  function draw(element, size) {
    const style = getComputedStyle(element);
    for (const { node, data, layout } of charts) {
      const zoomed = linked.includes(node) && node.layout ? [...node.layout.xaxis.range] : null;
      Plotly.react(node, coloured(data, style), { ...coloured(layout, style), ...size }, CONFIG);
      if (zoomed) Plotly.relayout(node, { "xaxis.range": zoomed }); // a follower's zoom is not kept by itself
    }
  }

  const drawOnScreen = () => draw(document.documentElement, {});

  function drawOnPaper() {
    const probe = document.createElement("div");
    probe.className = "on-paper";
    document.body.append(probe);
    draw(probe, ON_PAPER);
    probe.remove();
  }

  // A zoom of one time axis zooms them all; an axis that is there already is left alone, which ends the chain.
  function follow(source) {
    const [start, end] = source.layout.xaxis.range;
    for (const node of linked) {
      const [from, to] = node.layout.xaxis.range;
      if (from !== start || to !== end) Plotly.relayout(node, { "xaxis.range": [start, end] });
    }
  }

  drawOnScreen();
  for (const node of linked)
    node.on("plotly_relayout", (change) => {
      if (Object.keys(change).some((key) => key.startsWith("xaxis."))) follow(node);
    });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawOnScreen);
  addEventListener("beforeprint", drawOnPaper);
  addEventListener("afterprint", drawOnScreen);
})();
