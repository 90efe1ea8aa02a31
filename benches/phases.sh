# Where an instruction of a query belongs, for profile.sh and roofline.sh, which say `source`. Wants $flashray and $work.

# Lines "address count" to lines "phase count", or with "list" to lines "address phase".
phases() {
  sort >"$work/counts"
  cut -d' ' -f1 "$work/counts" | addr2line -e "$flashray" -f -i -C -a >"$work/chains"
  awk -v counts="$work/counts" -v list="${1:-}" '
    function flush() {
      if (address == "") return
      # The outermost function: the walk, or the loop that calls it.
      if (outer !~ /lanes::|::walk|wide::many/)
        phase = outer ~ /trace|rayon/ && chain ~ /src\/scene(\/many)?\.rs/ && chain !~ /from_bytes|check/ ? "call" : "other"
      else if (chain ~ /Given|prepare::|Prepared::new|Slabs<[^>]*>>?::new|Slabs::new|Packet<_>::(set|range)|Team::(set|range|one)|Heading::new|of_heading|Many::shared|Bundle>?::(set|put|turn|turn_some|survey|ray)|State::(gather|sort)|class_of|crowd::Rays>?::(set|turn)/) phase = "preparation"
      else if (chain ~ /walk\/block\.rs|walk\/leaf\.rs|group\/leaf\.rs|Team::leaf|Packet<_>::(test|triangle)|geom\/(triangle|hit)\.rs/) phase = "triangle test"
      else if (chain ~ /Slabs|bvh::walk::(both|boxes|pair|slab)|Team::meet|Range>?::(meet|met)|Packet<_>::meets|bundle::boxes|Prepared::slab/) phase = "box test"
      else if (chain ~ /heapless|Stack(<R>)?::|::wait|::nearest/) phase = "stack"
      else if (chain ~ /(wide|bvh)\/(walk|group|stream\/[a-z]*)\.rs|walk\/group\/mod\.rs/) phase = "node fetch and order"
      else phase = "call"
      of[address] = phase
      if (list) print "0x" address "\t" phase
    }
    /^0x/ { flush(); address = $0; sub(/^0x0*/, "", address); chain = ""; next }
    { chain = chain "\n" $0; if ($0 !~ /:([0-9]+|\?)( \(.*\))?$/) outer = $0 }
    END {
      flush()
      if (list) exit
      while ((getline line < counts) > 0) { split(line, f, " "); a = f[1]; sub(/^0x0*/, "", a); n[of[a]] += f[2] }
      for (p in n) print p "\t" n[p]
    }' "$work/chains"
}
