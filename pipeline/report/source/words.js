// Identifiers of files and settings in words.

const known = {
  deleva1996: 'de Leva (1996)',
  dumas2007: 'Dumas et al. (2007)',
  winter2009: 'Dempster after Winter (2009)',
  zatsiorsky2002: 'Zatsiorsky (2002)',
  zatsiorsky: 'Zatsiorsky',
  schneider2000: 'Schneider et al. (2000)',
  isb: 'the ISB',
  bone: 'the bone',
  deleva: 'de Leva',
};

/** "deleva1996": "de Leva (1996)"; other names lose their underscores, and a year is separated. */
export function inWords(name) {
  const text = String(name);
  if (known[text]) return known[text];
  const [, author, year] = /^([a-z]+)((?:19|20)\d\d)$/.exec(text) ?? [];
  if (author) return `${author.charAt(0).toUpperCase()}${author.slice(1)} (${year})`;
  return text.replaceAll('_', ' ');
}

const units = { m: 'm', mm: 'mm', kg: 'kg', deg: '°', s: 's', mib: 'MiB', kgm3: 'kg/m³' };
const named = { convention: 1, density_curve: 1, frames: 1, cuts: 1, method: 1, equations: 1, pose: 1, sex: 1, quantity: 1 };

/** A setting's key and value in words: ["stature (m)", "1.75"]; `key` may be a path of keys joined by " · ". */
export function settingInWords(key, value) {
  const last = key.split(' · ').at(-1);
  const [, stem, unit] = /^(.*)_([a-z0-9]+)$/.exec(last) ?? [];
  const term = units[unit] ? `${key.slice(0, key.length - last.length)}${stem} (${units[unit]})` : key;
  const said = value === true ? 'yes' : value === false ? 'no' : named[last] ? inWords(value) : String(value);
  return [term.replaceAll('_', ' '), said];
}
