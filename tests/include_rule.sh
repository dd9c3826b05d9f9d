#!/usr/bin/env bash
# The include rule: a folder includes only its own headers and the data type that the previous stage passes on, besides error/,
# threads/ and process/, which belong to no stage. Rooms within a folder are ordered: a file includes its own room and earlier
# ones. ITK headers stay in segmentation's .cpp files, VTK headers in pipeline's. Give another root to check that instead.
set -u
root=${1:-$(cd "$(dirname "$0")/.." && pwd)}
cd "$root" || exit 1

# other headers that a folder may include, as an extended regular expression
declare -A allowed=(
  [error]='error/'
  [threads]='threads/'
  [process]='(error|process)/'
  [segmentation]='(error|threads|process|segmentation)/'
  [inertia]='(error|threads|process|inertia)/|segmentation/volume/volume\.hpp'
  [dynamics]='(error|threads|process|dynamics)/|inertia/inertial\.hpp'
  [samples]='(error|threads|process|samples|segmentation|inertia)/'
  [pipeline]='(error|threads|process|segmentation|inertia|dynamics|samples|pipeline)/'
  [python]='(error|threads|process|segmentation|inertia|dynamics|samples|pipeline|python)/'
)
# a folder's rooms, in the order of the data; on_demand/ has the code of libraries loaded at run time
declare -A rooms=(
  [dynamics]='numbers scene system equations constraints inverse contacts methods run formats'
  [segmentation]='volume vocabulary grid files body proposal joints labelling'
  [pipeline]='files recordings body motion export video charts paper report stages verbs'
)
includes() { grep -rnE '^#include [<"]' --include='*.hpp' --include='*.cpp' "$@" 2>/dev/null; }

bad=0
for folder in "${!allowed[@]}"; do
  breaches=$(includes "$folder" | grep '#include "' | grep -vE "#include \"(${allowed[$folder]})")
  if [ -n "$breaches" ]; then
    echo "$folder/ includes what it may not:"
    echo "$breaches"
    bad=1
  fi
done
for folder in "${!rooms[@]}"; do
  later=
  for room in $(tr ' ' '\n' <<<"${rooms[$folder]}" | tac); do
    if [ -n "$later" ]; then
      breaches=$(includes "$folder/$room" | grep -E "#include \"$folder/($later)/")
      if [ -n "$breaches" ]; then
        echo "$folder/$room/ includes a later room (order: ${rooms[$folder]}):"
        echo "$breaches"
        bad=1
      fi
    fi
    later=$room${later:+|$later}
  done
  homeless=$(find "$folder" -maxdepth 1 \( -name '*.hpp' -o -name '*.cpp' \) 2>/dev/null)
  if [ -n "$homeless" ]; then
    echo "$folder/ has files outside of its rooms:"
    echo "$homeless"
    bad=1
  fi
done
itk=$(includes error threads process segmentation inertia dynamics samples pipeline | grep -E '#include [<"](itk|gdcm)' |
  grep -vE '^segmentation/[^:]*\.cpp:')
vtk=$(includes error threads process segmentation inertia dynamics samples pipeline | grep -E '#include [<"]vtk' |
  grep -vE '^pipeline/[^:]*\.cpp:')
if [ -n "$itk$vtk" ]; then
  echo "ITK belongs in segmentation's .cpp files, VTK in pipeline's:"
  echo "$itk$vtk"
  bad=1
fi
exit $bad
