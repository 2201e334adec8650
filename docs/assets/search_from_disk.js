// Search of pages opened from the disk: browsers start no worker from a file, so the search's worker runs in a hidden frame.
if (location.protocol === "file:") {
  const load = (page, src) =>
    new Promise((done, failed) => {
      const script = page.createElement("script");
      Object.assign(script, { src, onload: done, onerror: failed });
      page.body.append(script);
    });
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      const inside = frame.contentWindow;
      inside.postMessage = (data) => {
        const message = new MessageEvent("message", { data });
        this.dispatchEvent(message);
        this.onmessage?.(message);
      };
      inside.importScripts = (...urls) =>
        urls.reduce((before, src) => before.then(() => load(inside.document, src)), Promise.resolve());
      this.inside = inside;
      this.ready = load(inside.document, url);
    }
    postMessage(data) {
      this.ready.then(() => this.inside.dispatchEvent(new MessageEvent("message", { data: structuredClone(data) })));
    }
    terminate() {
      this.inside.frameElement.remove();
    }
  };
}
