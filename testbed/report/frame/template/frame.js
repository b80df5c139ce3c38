(() => {
  "use strict";
  // A notebook has a theme of its own: its background decides, not the system's setting.
  function grounded(element) {
    for (; element; element = element.parentElement) {
      const [red, green, blue, alpha = 1] = getComputedStyle(element).backgroundColor.match(/[\d.]+/g).map(Number);
      if (alpha > 0.5) return 0.299 * red + 0.587 * green + 0.114 * blue < 128 ? "dark" : "light";
    }
    return null;
  }

  try {
    const frame = window.frameElement, root = document.documentElement;
    const take = () => {
      root.classList.remove("dark", "light");
      const ground = grounded(frame.parentElement);
      if (ground) root.classList.add(ground);
    };
    take();
    new parent.MutationObserver(take).observe(parent.document.body, { attributes: true });
    new ResizeObserver(() => { frame.style.height = `${document.body.offsetHeight}px`; }).observe(document.body);
  } catch {
    // A host that keeps its frames apart: the system's colours, and the height that was given.
  }
})();
