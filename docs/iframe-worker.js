// Search in a folder of pages, without a server. A browser starts no worker from a file; this one runs the worker's
// script in a hidden frame and has the interface of `Worker` that the theme's search uses.
(function () {
  class IFrameWorker extends EventTarget {
    constructor(url) {
      super();
      this.onmessage = null;
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      document.body.appendChild(this.frame);
      const page = this.frame.contentWindow;
      page.document.open();
      page.document.write(
        "<html><body><script>" +
          "postMessage = parent.postMessage.bind(parent);" +
          "importScripts = (...urls) => urls.reduce((before, url) => before.then(() => new Promise((resolve) => {" +
          "const script = document.createElement('script'); script.src = url; script.onload = resolve;" +
          "document.body.appendChild(script); })), Promise.resolve());" +
          "<\/script><script src='" + url + "'><\/script></body></html>"
      );
      page.document.close();
      this.loaded = new Promise((resolve) => page.addEventListener("load", resolve));
      this.listen = (event) => {
        if (event.source !== page) return;
        const message = new MessageEvent("message", { data: event.data });
        this.dispatchEvent(message);
        if (this.onmessage) this.onmessage(message);
      };
      window.addEventListener("message", this.listen);
    }

    postMessage(data) {
      const send = () => this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }));
      this.loaded.then(send);
    }

    terminate() {
      window.removeEventListener("message", this.listen);
      this.frame.remove();
    }
  }

  if (location.protocol === "file:") {
    window.IFrameWorker = IFrameWorker;
    window.Worker = IFrameWorker;
  }
})();
