// Reads the data that report.cpp wrote into the page: one JSON block and binary blocks (zlib stream, base64).

export function readReport() {
  return JSON.parse(document.getElementById('report').textContent);
}

/** The bytes of the binary block with this name; null if the report has none. */
export async function readBlock(name) {
  const element = document.getElementById(`block-${name}`);
  if (!element) return null;
  const packed = Uint8Array.from(atob(element.textContent.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
