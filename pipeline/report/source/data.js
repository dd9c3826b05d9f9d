// What report.cpp wrote into the page: one JSON block and some binary blocks (zlib stream, base64).

export function readReport() {
  return JSON.parse(document.getElementById('report').textContent);
}

/** The bytes of a binary block; null where the report has none of this name. */
export async function readBlock(name) {
  const element = document.getElementById(`block-${name}`);
  if (!element) return null;
  const packed = Uint8Array.from(atob(element.textContent.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
