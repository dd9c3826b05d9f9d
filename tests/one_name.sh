#!/usr/bin/env bash
# All folders share the namespace borelli, so a type's name may occur in one header only: two types of one name, linked
# into one program, would break it without an error from the linker. Give another root to check that instead.
set -u
root=${1:-$(cd "$(dirname "$0")/.." && pwd)}
cd "$root" || exit 1
twice=$(grep -rhoE '^(struct|class|enum class|using) [A-Z][A-Za-z0-9]*( final)?( :| \{| =)' --include='*.hpp' \
  error threads process segmentation inertia dynamics samples pipeline python 2>/dev/null |
  sed -E 's/^(struct|class|enum class|using) ([A-Za-z0-9]*).*/\2/' | sort | uniq -d)
[ -z "$twice" ] && exit 0
for name in $twice; do
  echo "$name is declared more than once:"
  grep -rnE "^(struct|class|enum class|using) $name\b" --include='*.hpp' .
done
exit 1
