#!/bin/sh
# The installed `kinegraph`: runs kinegraph-COMMAND, which lies beside it.
folder=$(dirname "$(readlink -f "$0")")
commands() {
  for program in "$folder"/kinegraph-*; do
    printf ' %s' "${program##*/kinegraph-}"
  done
}
case ${1:-help} in
  help | -h | --help)
    echo "kinegraph: the 3D motion of people from the 2D poses that calibrated cameras see"
    echo
    echo "  kinegraph COMMAND [flags]"
    echo
    echo "Commands:$(commands)"
    echo "Flags of a command: kinegraph COMMAND --help, or man kinegraph-COMMAND"
    ;;
  --version) "$folder/kinegraph-track" --version | sed 's/^kinegraph-track/kinegraph/' ;;
  *)
    if [ ! -x "$folder/kinegraph-$1" ]; then
      echo "kinegraph: error: unknown command '$1'; commands:$(commands)" >&2
      exit 2
    fi
    program=$folder/kinegraph-$1
    shift
    exec "$program" "$@"
    ;;
esac
