#!/bin/bash
# All charts on one page, losses included: tests/bench/gallery.sh [--quick] [FOLDER]
#
# Runs what makes charts (built by the preset "release" with BORELLI_TESTS=ON) and leaves FOLDER/index.html (default:
# gallery/). What is whole already is not made again: remove its folder, or all, to have it anew. About half an hour;
# with --quick minutes: shorter runs, fewer scenes, the same page.
set -euo pipefail
budget=0.1 repeats=3 quick=
if [ "${1-}" = --quick ]; then quick=yes budget=0.004 repeats=1; shift; fi
out=$(realpath -m "${1:-gallery}")
cd "$(dirname "$0")/../.."
bin=build/release
mkdir -p "$out"
names=()
declare -A title command

# chart NAME TITLE COMMAND...: FOLDER/NAME by the command and a folder's name, unless it is there
chart() {
  local name=$1
  names+=("$name")
  title[$name]=$2
  shift 2
  command[$name]="$* ${out##*/}/$name"
  [ ! -d "$out/$name" ] || return 0
  if [ "$(type -t "$1")" != function ] && [ ! -x "$1" ]; then
    echo "gallery: $1 is not built: ${title[$name]} is left out" >&2
    return 0
  fi
  echo "gallery: ${title[$name]}" >&2
  rm -rf "$out/$name.part"
  if ! "$@" "$out/$name.part" >"$out/$name.log" 2>&1; then
    echo "gallery: it failed; see $out/$name.log" >&2
    exit 1
  fi
  mv "$out/$name.part" "$out/$name"
}

scenes=tests/bench/peers/scenes
all=($scenes/*.toml samples/{roundabout,double_pendulum,heavy_top,spinning_plate,shock,andrews,four_bar_2,four_bar_40,bouncing_ball,block_on_slope}.toml)
sizes=() map=() run=100000
if [ -n "$quick" ]; then
  all=($scenes/human_flight.toml samples/{double_pendulum,bouncing_ball}.toml)
  sizes=(8 6) map=(--end 1 --most-steps 500 --methods rk4,verlet,dopri5) run=5000
fi
measured=(--budget $budget --repeats $repeats)
voxel_chart() { $bin/voxel_chart "$1" "${sizes[@]}"; }
volume_economy() {
  $bin/borelli phantom --spacing 5 -o "$out/phantom.nii.gz"
  $bin/borelli economy "$out/phantom.nii.gz" --quantity hu --table-tolerance 0.05 -o "$1"
}

chart peers "Error against time, beside other programs" $bin/peers "${all[@]}" "${measured[@]}" \
  --equations recursive --methods dop853,dopri5,gbs,gauss16,rk4,semi_implicit_euler,cvode -o
chart orders "Orders of orientation on a tumbling body" $bin/peers samples/spinning_plate.toml --orders --end 2 \
  "${measured[@]}" --equations recursive -o
chart paper "The paper's other treatments of the equations" \
  $bin/paper samples/{double_pendulum,shock,roundabout}.toml "${measured[@]}" -o
[ -n "$quick" ] || chart figures "The paper's figures, from our runs" $bin/borelli figures -o
chart masses "Where methods fail: a heavier cube on the shock's bar" \
  $bin/borelli stability samples/shock.toml --vary 'solid[cube].shape.mass=1:1e6' "${map[@]}" -o
chart long "Energy and momentum over long runs" \
  $bin/borelli stability samples/pendulum.toml --long $run --steps 0.01 -o
chart model "The smallest model: a human on a bar, within 5 %" $bin/borelli economy $scenes/human_bar.toml --model-tolerance 0.05 -o
chart voxels "Volumes: error and time against voxel size" voxel_chart
command[voxels]="$bin/voxel_chart ${out##*/}/voxels ${sizes[*]}"
chart grids "Volumes: what a table needs, within 5 %" volume_economy
command[grids]="$bin/borelli phantom --spacing 5 -o phantom.nii.gz && $bin/borelli economy phantom.nii.gz --quantity hu --table-tolerance 0.05 -o ${out##*/}/grids"

html() { sed 's/&/\&amp;/g; s/</\&lt;/g; s/>/\&gt;/g'; }
{
  echo '<!doctype html><html lang="en"><meta charset="utf-8"><title>borelli: gallery</title>'
  echo '<meta name="viewport" content="width=device-width"><style>body{font:16px/1.5 sans-serif;max-width:80rem;margin:2rem auto;padding:0 1rem}'
  echo '.drawings{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(30rem,100%),1fr));gap:1rem}img{width:100%}code{font-size:.85em;overflow-wrap:anywhere}summary{cursor:pointer}</style>'
  echo '<h1>borelli: what accuracy costs, where methods fail, what a scene needs</h1>'
  echo '<p>Made by <code>tests/bench/gallery.sh</code>. Losses stand beside the rest. Times are processor time on one core.</p>'
  for name in "${names[@]}"; do
    [ -d "$out/$name" ] || continue
    printf '<h2>%s</h2>\n<p><code>%s</code></p>\n' "$(html <<<"${title[$name]}")" "$(html <<<"${command[$name]}")"
    [ ! -f "$out/$name/README.md" ] || printf '<p><a href="%s">Tables and notes</a></p>\n' "$name/README.md"
    find "$out/$name" -name '*.svg' -printf '%P\n' | sed 's|[^/]*$||' | sort -u | while read -r folder; do
      [ -z "$folder" ] || echo "<h3>$(html <<<"${folder%/}")</h3>"
      for page in "$out/$name/$folder"*.html; do
        [ ! -f "$page" ] || echo "<p><a href='$name/$folder${page##*/}'>The page, with tips and curves to be taken out</a></p>"
      done
      drawings=() others=()
      for drawing in "$out/$name/$folder"*.svg; do
        case ${drawing##*/} in
          contacts_time.svg | position_time.svg | orientation_time.svg | limits*.svg | error.svg | time.svg | cost.svg) drawings+=("$drawing") ;;
          *) others+=("$drawing") ;;
        esac
      done
      [ ${#drawings[@]} -gt 0 ] || drawings=("${others[@]}") others=("${others[@]:${#others[@]}}")
      show() {  # eager, or lazy for what is folded away; DRAWINGS
        local when=$1
        shift
        echo '<div class="drawings">'
        for drawing in "$@"; do
          echo "<img loading='$when' src='$name/$folder${drawing##*/}' alt='$(basename "$drawing" .svg)'>"
        done
        echo '</div>'
      }
      show eager "${drawings[@]}"
      [ ${#others[@]} -eq 0 ] || { echo '<details><summary>More drawings</summary>' && show lazy "${others[@]}" && echo '</details>'; }
    done
  done
} >"$out/index.html.part"
mv "$out/index.html.part" "$out/index.html"
echo "$out/index.html"
