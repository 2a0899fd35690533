# Runs inside a throwaway copy of a Debian system: installs, uses, removes and purges /run/counterpoint.deb.
export DEBIAN_FRONTEND=noninteractive
install_package() { dpkg -i /run/counterpoint.deb; }
data=/var/lib/counterpoint

install_package
id counterpoint
[ "$(stat -c '%U %a' $data)" = "counterpoint 700" ]
[ -f /etc/counterpoint/counterpointd.toml ]
[ -z "$(dpkg --audit)" ]
if command -v systemd-analyze >/dev/null; then
    systemd-analyze verify /usr/lib/systemd/system/counterpointd.service 2>&1 | grep counterpointd.service && exit 1
fi
echo "ok: installed"

cd /tmp
setpriv --reuid counterpoint --regid counterpoint --clear-groups \
    counterpointd --config /etc/counterpoint/counterpointd.toml --listen 127.0.0.1:0 >/tmp/address 2>/tmp/log &
server=$!
while ! grep -q listening /tmp/address; do kill -0 $server || { cat /tmp/log; exit 1; }; done
address=$(sed -n 's|.*listening on http://||p' /tmp/address)
printf 'O1\nT0101\nG97 S1000 M3\nG0 X20. Z2.\nG1 Z-10. F0.2\nM30\n' >/tmp/part.nc
job=$(counterpoint submit --server "http://$address" --machine fanuc-lathe /tmp/part.nc)
counterpoint wait --server "http://$address" "$job"
kill $server
wait $server
[ "$(stat -c '%U' $data/ledger.redb 2>/dev/null || stat -c '%U' $data/lock)" = counterpoint ]
echo "ok: ran a job"

# The commands and the configuration of docs/security.md, with a free port; they need a certificate and a secret.
if command -v openssl >/dev/null; then
    fence() { sed -n "/^## Files/,/^## Identities/{/^\`\`\`$1\$/,/^\`\`\`\$/{/^\`\`\`/d;p}}" /run/security.md; }
    openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=DNS:localhost \
        -addext basicConstraints=critical,CA:FALSE -keyout key.pem -out cert.pem 2>/dev/null
    echo 0123456789abcdef0123456789abcdef >mes.secret
    fence sh >/tmp/guard.sh
    sh -e /tmp/guard.sh >/tmp/token
    fence toml | sed 's/0.0.0.0:7878/127.0.0.1:0/' >/etc/counterpoint/counterpointd.toml
    setpriv --reuid counterpoint --regid counterpoint --clear-groups \
        counterpointd --config /etc/counterpoint/counterpointd.toml >/tmp/address 2>/tmp/log &
    server=$!
    while ! grep -q listening /tmp/address; do kill -0 $server || { cat /tmp/log; exit 1; }; done
    port=$(sed -n 's|.*listening on https://.*:||p' /tmp/address)
    COUNTERPOINT_TOKEN=$(cat /tmp/token) COUNTERPOINT_CA=/etc/counterpoint/cert.pem \
        counterpoint submit --server "https://localhost:$port" --machine fanuc-lathe /tmp/part.nc
    kill $server
    wait $server
    [ "$(stat -c '%U %a' /var/log/counterpoint/audit.jsonl)" = "counterpoint 600" ]
    grep -q SubmitJob /var/log/counterpoint/audit.jsonl
else
    touch /var/log/counterpoint/audit.jsonl
fi
echo "ok: guarded"

dpkg -r counterpoint
[ -d $data ] && [ -f /etc/counterpoint/counterpointd.toml ] && [ ! -e /usr/bin/counterpointd ]
echo "ok: kept on remove"

install_package
dpkg -P counterpoint
[ -d $data ] && [ -f /var/log/counterpoint/audit.jsonl ] && [ ! -e /etc/counterpoint/counterpointd.toml ]
echo "ok: kept on purge"

install_package
echo "counterpoint counterpoint/remove-data boolean true" | debconf-set-selections
dpkg -P counterpoint
[ ! -e $data ] && [ ! -e /var/log/counterpoint ]
echo "ok: removed as asked"

install_package
dpkg -P counterpoint
[ ! -e $data ]
echo "ok: removed when empty"
