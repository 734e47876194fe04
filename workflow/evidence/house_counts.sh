# bash house_counts.sh ROOT COMMIT: what there is of the house at a commit, JSON.
root=$1 commit=$2
lines() {  # FOLDER
  git -C "$root" ls-tree -r --name-only "$commit" "$1" | grep -E '\.(cc|h)$' |
    while read -r file; do git -C "$root" show "$commit:$file"; done | wc -l
}
printf '{"lines": {'
separator=''
for folder in core solvers apps python tests; do
  printf '%s"%s": %d' "$separator" "$folder" "$(lines "$folder")"
  separator=', '
done
printf '}, "keys": %d}\n' "$(git -C "$root" show "$commit:docs/configuration.md" | grep -c '^| `')"
