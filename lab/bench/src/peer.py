"""One peer of one workload, run when asked: reads `run N` or `check` on stdin, answers a line of JSON."""
import json, os, sys

folder, data, workload, peer, coretype = sys.argv[1:6]
sys.argv = ["bench_peers.py", "--threads", "1", "--data", data, "--coretype", coretype]
sys.path.insert(0, folder)
sys.dont_write_bytecode = True
import bench_peers as B
import resource, time
import numpy as np

register(B)


def from_disk(workload, peer):
    """The peer's fit with reading its table by pandas before it; which columns there are was decided beforehand."""
    f, load, _ = B.PEERS[(workload.replace("-disk", ""), peer)]
    file = "w3_1m.csv" if workload.endswith("1m") else "w3_200k.csv"

    def whole(known, phases):
        fresh = B.load_pps(file)
        fresh["jc"], fresh["mm"] = known["jc"], known["mm"]
        return f(fresh, phases)

    return whole, load


if peer.startswith("pandas+"):
    f, load = from_disk(workload, peer.removeprefix("pandas+"))
else:
    f, load, _ = B.PEERS[(workload, peer)]
loaded = load()
before = B.rss()
answer = check = None


def say(what):
    print(json.dumps(what), flush=True)


say(dict(ready=True, versions=dict(python=sys.version.split()[0], numpy=np.__version__)))
for line in sys.stdin:
    word, *rest = line.split()
    if word == "run":
        cpu, wall = [], []
        for _ in range(int(rest[0])):
            phases = B.Phases()
            t, c = time.perf_counter(), time.process_time()
            answer, check = f(loaded, phases)
            cpu.append(time.process_time() - c)
            wall.append(time.perf_counter() - t)
        scale = answer.get("scale", 1.0)
        say(dict(cpu=[c * scale for c in cpu], wall=[w * scale for w in wall]))
    elif word == "check":
        out = {k: v for k, v in answer.items() if k != "x"}
        peak = B.rss()
        out.update(check() if check else {})
        out = {k: float(v) for k, v in out.items() if isinstance(v, (int, float, np.number)) and v == v}
        say(dict(answer=out, peak_mb=peak, before_mb=before))
    else:
        break
