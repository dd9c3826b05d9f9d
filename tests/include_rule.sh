#!/usr/bin/env bash
# The include rule: a folder includes only its own headers and the data type that the stage before it hands on,
# besides error/, threads/ and process/, which belong to no stage.
# ITK headers stay in segmentation's .cpp files, VTK headers in pipeline's. Give another root to check that instead.
set -u
root=${1:-$(cd "$(dirname "$0")/.." && pwd)}
cd "$root" || exit 1

# what a folder may include of the others, as an extended regular expression
declare -A allowed=(
  [error]='error/'
  [threads]='threads/'
  [process]='(error|process)/'
  [segmentation]='(error|threads|process|segmentation)/'
  [inertia]='(error|threads|process|inertia)/|segmentation/volume\.hpp'
  [dynamics]='(error|threads|process|dynamics)/|inertia/inertial\.hpp'
  [samples]='(error|threads|process|samples|segmentation|inertia)/'
  [pipeline]='(error|threads|process|segmentation|inertia|dynamics|samples|pipeline)/'
)
bad=0
for folder in "${!allowed[@]}"; do
  breaches=$(grep -rnE '^#include "' --include='*.hpp' --include='*.cpp' "$folder" 2>/dev/null |
    grep -vE "#include \"(${allowed[$folder]})")
  if [ -n "$breaches" ]; then
    echo "$folder/ includes what it may not:"
    echo "$breaches"
    bad=1
  fi
done
itk=$(grep -rnE '^#include [<"](itk|gdcm)' --include='*.hpp' --include='*.cpp' error threads process segmentation inertia dynamics samples pipeline |
  grep -vE '^segmentation/[^:]*\.cpp:')
vtk=$(grep -rnE '^#include [<"]vtk' --include='*.hpp' --include='*.cpp' error threads process segmentation inertia dynamics samples pipeline |
  grep -vE '^pipeline/[^:]*\.cpp:')
if [ -n "$itk$vtk" ]; then
  echo "ITK belongs in segmentation's .cpp files, VTK in pipeline's:"
  echo "$itk$vtk"
  bad=1
fi
exit $bad
