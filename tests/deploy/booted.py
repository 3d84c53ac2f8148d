"""A root booted by systemd in a container of systemd-nspawn, in which a script asks the questions."""

import shutil

from clean_root import run

# Each command's output goes into a file named by its first word.
QUESTIONS = r"""#!/bin/sh
cd /root/told || exit 1
service=collided.service config=/etc/collided/collided.toml
touch booted
systemctl show -p Type,NRestarts,User,ActiveState,StatusText $service >show
collidectl detect --frames /srv/0.obj /srv/1.obj --json --server unix:/run/collided/socket >detect 2>&1
python3 -c 'import urllib.request as u; print(u.urlopen("http://127.0.0.1:9464/readyz").read().decode().strip())' >ready 2>&1
stat -c '%a %U %G %n' /run/collided /run/collided/socket >modes 2>&1
systemctl reload $service >/dev/null 2>&1
echo $? >reload

cp $config /root/config
echo 'max-scenes = 0' >$config
systemctl reload $service >/dev/null 2>&1
echo $? >bad-reload
systemctl is-active $service >>bad-reload
cp /root/config $config

mkdir -p /run/systemd/system/$service.d
printf '[Service]\nWatchdogSec=2\nLimitCORE=0\n' >/run/systemd/system/$service.d/watchdog.conf
systemctl daemon-reload
systemctl restart $service
kill -STOP "$(systemctl show -p MainPID --value $service)"
for try in $(seq 600); do
  if [ "$(systemctl show -p NRestarts --value $service)" = 1 ] && systemctl -q is-active $service; then break; fi
  sleep 0.1
done
systemctl show -p NRestarts,ActiveState $service >stuck

if [ -e /usr/lib/systemd/system/collided@.service ]; then
  systemctl start collided@3.service
  systemctl show -p ActiveState,StatusText collided@3.service >instance
  systemctl is-active $service >beside-instance
  systemctl stop collided@3.service
  systemctl start $service
fi

systemctl stop $service
systemctl show -p Result,ActiveState,ExecMainStatus $service >stop
journalctl -u $service -o cat --no-pager >journal
systemctl poweroff
"""
UNIT = """[Unit]
After=collided.service
[Service]
Type=oneshot
ExecStart=/root/questions
"""


def boot(root):
    """What the questions were answered, by name; {} if there is no systemd-nspawn, or it cannot boot here."""
    if not shutil.which("systemd-nspawn"):
        return {}
    root.write("root/questions", QUESTIONS)
    (root.folder / "root/questions").chmod(0o755)
    told = root.folder / "root/told"
    told.mkdir()
    unit = root.folder / "etc/systemd/system/questions.service"
    root.write(unit.relative_to(root.folder), UNIT)
    wanted = root.folder / "etc/systemd/system/multi-user.target.wants/questions.service"
    wanted.symlink_to("/etc/systemd/system/questions.service")
    said = run("unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc", "systemd-nspawn", "--quiet", "--boot",
               "--register=no", "--keep-unit", "--private-network", "--console=pipe", "-D", root.folder)
    wanted.unlink()
    unit.unlink()
    answers = {path.name: path.read_text() for path in told.iterdir()}
    assert not answers or "journal" in answers, (answers, said.stdout)
    return answers
